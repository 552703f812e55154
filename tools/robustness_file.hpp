#pragma once

#include <filesystem>

#include "core/control/robustness/record.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// A record as JSON and back, to the same bits. What is not finite is null.
Json to_json(const robustness::Record& record);
Json to_json(const robustness::Outcome& outcome);

/// Reads what write_record wrote. Errors: InputError for a file that is missing or is no such
/// record.
robustness::Record read_record(const std::filesystem::path& path);

/// Writes a record. Errors: those of WholeFile.
void write_record(const robustness::Record& record, const std::filesystem::path& path);

}  // namespace stillframe::tools

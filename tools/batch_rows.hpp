#pragma once

#include <optional>
#include <vector>

#include "tools/row_file.hpp"
#include "tools/run/study.hpp"

namespace stillframe::tools {

/// A run a row, by what its files hold.
extern const RowKind batch_rows;

/// Runs, whose rows are those of --json (docs/json/batch.schema.json).
RowStudy batch_study(const std::vector<StudyCase>& cases, std::optional<double> duration_s);

}  // namespace stillframe::tools

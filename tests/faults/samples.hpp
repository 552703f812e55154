#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/faults/trace.hpp"

namespace stillframe::faults {

/// Writes NAME.csv into a folder: a row for each sample that the relay saw, with the state of the
/// controller (controller_status_t), the active and the passive frame's accelerations, m/s^2, and
/// the forces that were applied, N. Errors: std::runtime_error.
void write_samples(const std::filesystem::path& folder, const std::string& name, const Trace& trace,
                   const std::vector<Accelerations>& passive);

}  // namespace stillframe::faults

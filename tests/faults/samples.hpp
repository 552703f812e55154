#pragma once

#include <filesystem>
#include <string>

#include "tests/faults/trace.hpp"
#include "tests/faults/workbench.hpp"

namespace stillframe::faults {

/// Writes NAME.csv into a folder: a row for each sample that the relay saw, with the state of the
/// controller (controller_status_t), the active and the passive frame's accelerations, m/s^2, and
/// the forces that were applied, N. Errors: std::runtime_error.
void write_samples(const std::filesystem::path& folder, const std::string& name, const Trace& trace,
                   Workbench& bench);

}  // namespace stillframe::faults

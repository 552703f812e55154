#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace stillframe::report {

/// The answer to "did these two runs say the same?".
struct LogDifference {
  bool identical = false;
  std::int64_t n_measurements = 0;  ///< compared, repeats dropped
  std::int64_t n_commands = 0;      ///< compared, repeats dropped
  bool same_run_id = false;         ///< run_id names the run and is left out of the comparison
  std::string
      first_difference;  ///< channel, position, seq, field and both values; empty if identical
};

/// Whether two logs carry bit-identical measurement and command payloads: the same bytes in the
/// same order within each channel, identical repeats dropped, run_id and the numbers of the
/// processes left out. Errors: InputError for a missing file, or a log without a measurement.
LogDifference compare_logs(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace stillframe::report

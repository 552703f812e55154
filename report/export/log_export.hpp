#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/numerics/infinity.hpp"
#include "report/export/signal_columns.hpp"

namespace stillframe::report {

/// What of a log is exported.
struct ExportSettings {
  std::optional<std::int64_t> run_id;    ///< without it the log must hold exactly one run
  std::optional<int> plant = {};         ///< as in ScanSettings
  double from_s = -infinity;             ///< s of plant time, included
  double to_s = infinity;                ///< s of plant time, included
  std::vector<std::string> channels;     ///< labels or groups (signal_columns.hpp); empty: all
  std::function<void(double)> progress;  ///< the share of the work that is done, 0 to 1
};

/// What was exported.
struct ExportSummary {
  LogScan scan;  ///< of the whole run
  std::vector<SignalColumn> columns;
  std::int64_t n_rows = 0;
  double first_s = 0, last_s = 0;  ///< s of plant time, of the first and the last row
  std::int64_t n_bytes = 0;        ///< of the file
};

/// Writes the samples of a run as RFC 4180 text, a row a sample: seq, time_s, then the signals; the
/// header names them as in `sigma:leg_1 [N]`. Numbers are as short as they can be to read back to
/// the same bits. A sample without an answer has NaN for its commands. In bounded memory, and no
/// half file is ever left. Errors: InputError as scan_log, for channels that are not in the log, a
/// choice without samples, or a file that cannot be written.
ExportSummary export_csv(const std::filesystem::path& log, const ExportSettings& settings,
                         const std::filesystem::path& file);

/// Writes the samples of a run as a MATLAB level-5 file: seq, time_s, and for each group of signals
/// a matrix, a row a sample, with its _names and _unit; docs/exports.md lists the rest. In bounded
/// memory (the log is read twice), and no half file is ever left. Errors: as export_csv, and
/// InputError, before anything is written, if a matrix would be larger than 2 GiB.
ExportSummary export_mat(const std::filesystem::path& log, const ExportSettings& settings,
                         const std::filesystem::path& file);

}  // namespace stillframe::report

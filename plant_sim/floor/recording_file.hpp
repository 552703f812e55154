#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::floor {

/// A recording of accelerations, or of forces, as it stands in its file.
struct RecordingFile {
  double sample_rate_hz = 0.0;
  std::vector<std::string> columns;  ///< names of what is recorded, a column time_s left out
  Eigen::MatrixXd acceleration;      ///< columns.size() x samples, in the file's units
};

/// Reads a CSV file, UTF-8 with or without its mark: comment lines that begin with '#', a header of
/// column names, rows of numbers. The comments state fs_hz=RATE, n=ROWS and units=UNITS, and may
/// state columns=NAMES; words without these keys are free. n guards against gaps; so does a column
/// time_s, if there is one, whose steps must be even. units: those that are asked for. Errors:
/// InputError "file:line:column: ..." for a missing or empty file, a missing, doubtful or
/// contradicting statement, a row of the wrong length, a value that is not a finite number, a gap.
RecordingFile read_recording(const std::filesystem::path& path, const std::string& units = "m/s^2");

}  // namespace stillframe::floor

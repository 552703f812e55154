#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
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

/// What of a recording is played.
struct RecordingPart {
  std::filesystem::path file;
  std::string units;
  std::vector<std::string> columns;
  double scale = 1.0, start_s = 0.0;  ///< s into the recording
};

/// What whoever asked for a recording throws at its file, its start, or one of the columns.
struct RecordingErrors {
  std::function<void(const std::string&)> file, start;
  std::function<void(std::size_t column, const std::string&)> column;
};

/// The columns of a recording from its start to its end, scaled, faded in and out within a second
/// and resampled to a rate (Hz): columns x samples. Errors: as read_recording; `errors` for a file
/// that is missing or whose rate has no ratio to this one, less than two seconds, unknown columns.
Eigen::MatrixXd play_recording(const RecordingPart& part, double rate,
                               const RecordingErrors& errors);

}  // namespace stillframe::floor

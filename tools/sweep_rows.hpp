#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/json.hpp"
#include "tools/sweep_grid.hpp"

namespace stillframe::tools {

/// What the design of one point of a sweep comes to; NaN where it has no such figure.
struct SweepRow {
  std::size_t point = 0;
  std::vector<std::string> values;
  std::string scene_hash, failure;  ///< why there is no design, or empty
  bool stable = false;
  double radius = 0;                 ///< spectral radius of the loop that runs
  double disk = 0, disk_hz = 0;      ///< all-leg disk margin
  double price_db = 0;               ///< of sampling, up to four targets
  double peak = 0, peak_hz = 0;      ///< largest singular value of T, floor to outputs, and where
  std::vector<double> transmission;  ///< the same at frequencies that are asked for
};

/// A sweep: scene, keys, and the frequencies at which T is told.
struct SweepQuestion {
  SceneBlocks blocks;
  SweepGrid grid;
  std::vector<double> at_hz;
};

/// Designs point i, whatever comes of it.
SweepRow sweep_row(const SweepQuestion& question, std::size_t i);

/// A line of JSON a row, which is what --out keeps and what the rows of --json are.
Json to_json(const SweepQuestion& question, const SweepRow& row);

/// A file of rows that grows by whole lines, in which what is there already need not be computed
/// again.
class SweepFile {
 public:
  /// Opens or makes it; a last line without an end, of a program that was killed, is taken off.
  /// Errors: InputError of a file that cannot be read or written, or that is none of these.
  explicit SweepFile(std::filesystem::path path);

  /// The row of a point as it stands there, if it is of the same scene, frequencies and version.
  std::optional<SweepRow> find(const SweepQuestion& question, std::size_t i) const;
  /// Errors: Failure where the file does not grow.
  void add(const SweepQuestion& question, const SweepRow& row);

 private:
  std::filesystem::path path_;
  std::map<std::string, Json> rows_;  ///< by version, hash and values
};

}  // namespace stillframe::tools

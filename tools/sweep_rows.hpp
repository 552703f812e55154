#pragma once

#include <vector>

#include "tools/row_file.hpp"
#include "tools/sweep_grid.hpp"

namespace stillframe::tools {

/// A sweep: scene, keys, and the frequencies at which T is told.
struct SweepQuestion {
  SceneBlocks blocks;
  SweepGrid grid;
  std::vector<double> at_hz;
};

/// A design a row, of a scene by its hash with the values that were set.
extern const RowKind sweep_rows;

/// The designs of a sweep, whose rows are those of --json (docs/json/sweep.schema.json).
RowStudy sweep_study(const SweepQuestion& question);

}  // namespace stillframe::tools

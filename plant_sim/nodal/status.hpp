#pragma once

namespace stillframe::nodal {

enum class Status { ok, position_not_found, matrix_singular, too_many_steps, failed };

/// What an error counts against (inf-norm): positions and rates of the nodes.
struct ErrorScale {
  double position = 0, rate = 0;  ///< m and rad, per s
};

}  // namespace stillframe::nodal

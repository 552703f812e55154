#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/linear/multisine_plan.hpp"

namespace stillframe::report {

struct RunLog;

/// A frequency response measured from data.
struct FrequencyResponse {
  std::vector<double> frequencies_hz;  ///< n_f, Hz
  std::vector<Eigen::MatrixXcd> T;     ///< n_f matrices n_y x n_w, output unit per input unit
  Eigen::MatrixXd singular_values;     ///< n_f x min(n_y, n_w), largest first
  Eigen::VectorXd
      input_condition;  ///< n_f, condition number of W, 1 for perfectly orthogonal inputs
  Eigen::VectorXd off_line_ratio;  ///< n_f, output one main lobe beside the line over that on it,
                                   ///< NaN between two lines: noise, distortion and free motion
};

/// T(f) = Y(f) W(f)^-1, columns the blocks, each entry one bin of a 4-term Blackman-Harris windowed
/// DFT of a steady part. The window leaks less than -92 dB beyond 4 bins, so free motion of an
/// undamped plant that stays 4 bins away from the lines does no harm. inputs: n x n_w, outputs: n x
/// n_y, a row a sample; the steady part of block b is taken from row first_row + b (ramp_s +
/// window_s) rate + ramp_s rate on. first_row is 1 for the rows of a log, since the input that was
/// held from t_k on stands in the row of t_{k+1}. Errors: std::invalid_argument on shapes,
/// InputError for a plan that cannot be (lines off the 4-bin raster or beyond the Nyquist rate,
/// parts that are no whole samples, blocks unlike inputs), rows that end before the plan does,
/// non-finite data, or inputs that do not move (W singular).
FrequencyResponse identify(const MultisinePlan& plan, const Eigen::MatrixXd& inputs,
                           const Eigen::MatrixXd& outputs, Eigen::Index first_row = 1);

/// From floor acceleration to frame acceleration, from a log.
/// Errors: those above, and InputError if a sample that the plan needs was lost or the rates
/// differ.
FrequencyResponse identify(const MultisinePlan& plan, const RunLog& log);

/// Singular values of each matrix, largest first: n_f x min(rows, columns).
Eigen::MatrixXd singular_values(const std::vector<Eigen::MatrixXcd>& matrices);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>

#include "core/systems/multisine_plan.hpp"
#include "report/identification/frequency_response.hpp"

namespace stillframe::report {

/// T(f) = Y(f) W(f)^-1, columns the blocks, each entry one bin of a 4-term Blackman-Harris windowed
/// DFT of a steady part. The window leaks less than -92 dB beyond 4 bins, so free motion of an
/// undamped plant that stays 4 bins away from the lines does no harm.
///
/// What y - T w leaves in bins between the lines is noise, distortion and free motion. It is taken
/// from the quiet bins next to each line, where a Hann window is zero of all lines (2 and 6 bins
/// away from it on either side), so dof is their number times that of the blocks.
///
/// inputs: n x n_w, outputs: n x n_y, a row a sample; the steady part of block b is taken from row
/// first_row + b (ramp_s + window_s) rate + ramp_s rate on. first_row is 1 for the rows of a log,
/// since the input that was held from t_k on stands in the row of t_{k+1}. Errors:
/// std::invalid_argument on shapes, InputError for a plan that cannot be (lines off the 4-bin
/// raster or beyond the Nyquist rate, parts that are no whole samples, blocks unlike inputs), rows
/// that end before the plan does, non-finite data, or inputs that do not move (W singular).
FrequencyResponse identify(const MultisinePlan& plan, const Eigen::MatrixXd& inputs,
                           const Eigen::MatrixXd& outputs, Eigen::Index first_row = 1);

/// The most of a steady part that may be lost, a share of its samples: beyond it, what is filled in
/// could be seen in the result.
inline constexpr double largest_lost_share = 0.05;

/// Puts in rows that are not finite in steady parts: everything that is excited repeats itself four
/// times in one, so a lost sample is the mean of those a quarter of the part away. Rows outside
/// steady parts become zero. Answers how many rows of steady parts were filled in. Errors:
/// InputError if a part has lost more than largest_lost_share of its rows, or a sample in all four
/// of its places, or cannot be divided by four.
Eigen::Index fill_lost_rows(const MultisinePlan& plan, Eigen::MatrixXd& inputs,
                            Eigen::MatrixXd& outputs, Eigen::Index first_row = 1);

}  // namespace stillframe::report

#include "report/identification/identification.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/yaml/input_error.hpp"
#include "report/log/run_log.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Half width of the window's main lobe, in bins: further away its transform is below -92 dB, and
/// at whole bins it is zero.
constexpr Index main_lobe_bins = 4;

/// A number that must be whole up to rounding. Errors: InputError.
Index whole(double value, const std::string& what) {
  const double nearest = std::round(value);
  if (!(std::abs(value - nearest) <= 1e-9 * std::max(1.0, std::abs(value)))) {
    throw InputError("multisine: " + what + ": found " + std::to_string(value) +
                     ", allowed are whole numbers");
  }
  return static_cast<Index>(nearest);
}

/// The plan in samples and bins.
struct Raster {
  Index ramp = 0, window = 0, n_blocks = 0;
  std::vector<Index> bins;

  Index start_of(Index block) const { return block * (ramp + window) + ramp; }
};

Raster raster_of(const MultisinePlan& plan) {
  if (!(plan.sample_rate_hz > 0) || !(plan.window_s > 0) || !(plan.ramp_s >= 0) ||
      plan.n_blocks < 1) {
    throw InputError(
        "multisine: sample_rate_hz, window_s and n_blocks must be positive, ramp_s not negative");
  }
  Raster raster{.ramp = whole(plan.ramp_s * plan.sample_rate_hz, "samples of ramp_s"),
                .window = whole(plan.window_s * plan.sample_rate_hz, "samples of window_s"),
                .n_blocks = plan.n_blocks,
                .bins = {}};
  if (plan.frequencies_hz.empty()) throw InputError("multisine: frequencies_hz: none given");
  for (const double frequency : plan.frequencies_hz) {
    const std::string name = "frequencies_hz " + std::to_string(frequency);
    const Index multiple =
        whole(frequency * plan.window_s / main_lobe_bins, name + " in units of 4 / window_s");
    const Index bin = main_lobe_bins * multiple;
    if (bin < main_lobe_bins || bin + main_lobe_bins > raster.window / 2) {
      throw InputError("multisine: " + name +
                       ": allowed are 4 / window_s to the Nyquist rate less that");
    }
    if (!raster.bins.empty() && bin <= raster.bins.back()) {
      throw InputError("multisine: " + name + ": the frequencies must increase");
    }
    raster.bins.push_back(bin);
  }
  return raster;
}

void check_data(const MultisinePlan& plan, const Raster& raster, const MatrixXd& inputs,
                const MatrixXd& outputs, Index first_row) {
  if (inputs.rows() != outputs.rows() || outputs.cols() == 0 || first_row < 0) {
    throw std::invalid_argument("identify: inputs of " + std::to_string(inputs.rows()) +
                                " rows, outputs of " + std::to_string(outputs.rows()) + " x " +
                                std::to_string(outputs.cols()) + ", first_row " +
                                std::to_string(first_row));
  }
  if (inputs.cols() != plan.n_blocks) {
    throw InputError("multisine: n_blocks: found " + std::to_string(plan.n_blocks) +
                     ", the data have " + std::to_string(inputs.cols()) +
                     " inputs and need as many blocks");
  }
  const Index needed = first_row + plan.n_blocks * (raster.ramp + raster.window);
  if (inputs.rows() < needed) {
    throw InputError("multisine: the data end at sample " + std::to_string(inputs.rows()) +
                     ", the plan needs " + std::to_string(needed));
  }
  if (!inputs.allFinite() || !outputs.allFinite()) {
    throw InputError("multisine: the data hold values that are not finite");
  }
}

/// 4-term Blackman-Harris window, periodic. Source: F. J. Harris, On the use of windows for
/// harmonic analysis with the discrete Fourier transform, Proc. IEEE 66 (1978), table 1.
VectorXd blackman_harris(Index n) {
  const double step = 2 * std::numbers::pi / static_cast<double>(n);
  return VectorXd::NullaryExpr(n, [step](Index k) {
    const double phase = step * static_cast<double>(k);
    return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) -
           0.01168 * std::cos(3 * phase);
  });
}

/// exp(-2 pi j k bin / n) w[k], the phase reduced to whole turns before it is rounded.
VectorXcd analyser(const VectorXd& window, Index bin) {
  const Index n = window.size();
  return VectorXcd::NullaryExpr(n, [&](Index k) {
    const double turns = static_cast<double>((k * bin) % n) / static_cast<double>(n);
    return std::polar(window(k), -2 * std::numbers::pi * turns);
  });
}

/// One bin of every channel (columns of data) in every block: channels x blocks.
MatrixXcd bin_of_blocks(const Raster& raster, const VectorXcd& analyser, const MatrixXd& data,
                        Index first_row) {
  MatrixXcd result(data.cols(), raster.n_blocks);
  for (Index b = 0; b < raster.n_blocks; ++b) {
    const auto steady = data.middleRows(first_row + raster.start_of(b), raster.window);
    result.col(b) = steady.transpose() * analyser;
  }
  return result;
}

/// Norm of the outputs one main lobe beside a line, where no steady response is left: what is there
/// is noise, distortion or free motion. NaN if both neighbours are lines themselves.
double off_line_norm(const Raster& raster, const VectorXd& window, Index bin,
                     const MatrixXd& outputs, Index first_row) {
  for (const Index neighbour : {bin - main_lobe_bins, bin + main_lobe_bins}) {
    const bool excited =
        std::find(raster.bins.begin(), raster.bins.end(), neighbour) != raster.bins.end();
    if (neighbour == 0 || excited) continue;
    return bin_of_blocks(raster, analyser(window, neighbour), outputs, first_row).norm();
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double condition_of(const MatrixXcd& W) {
  const VectorXd sigma = Eigen::JacobiSVD<MatrixXcd>(W).singularValues();
  return sigma(0) / sigma(sigma.size() - 1);
}

/// Beyond this the inputs of the blocks are one and the same experiment; the plan's own are at 1.
constexpr double largest_condition = 1e6;

}  // namespace

MatrixXd singular_values(const std::vector<MatrixXcd>& matrices) {
  if (matrices.empty()) return {};
  const Index n = std::min(matrices.front().rows(), matrices.front().cols());
  MatrixXd values(static_cast<Index>(matrices.size()), n);
  for (std::size_t l = 0; l < matrices.size(); ++l) {
    values.row(static_cast<Index>(l)) =
        Eigen::JacobiSVD<MatrixXcd>(matrices[l]).singularValues().transpose();
  }
  return values;
}

FrequencyResponse identify(const MultisinePlan& plan, const MatrixXd& inputs,
                           const MatrixXd& outputs, Index first_row) {
  const Raster raster = raster_of(plan);
  check_data(plan, raster, inputs, outputs, first_row);
  const VectorXd window = blackman_harris(raster.window);
  const auto n_lines = static_cast<Index>(raster.bins.size());
  FrequencyResponse response{.frequencies_hz = plan.frequencies_hz,
                             .T = {},
                             .singular_values = {},
                             .input_condition = VectorXd(n_lines),
                             .off_line_ratio = VectorXd(n_lines)};
  for (Index l = 0; l < n_lines; ++l) {
    const Index bin = raster.bins[static_cast<std::size_t>(l)];
    const VectorXcd on_line = analyser(window, bin);
    const MatrixXcd W = bin_of_blocks(raster, on_line, inputs, first_row);
    const MatrixXcd Y = bin_of_blocks(raster, on_line, outputs, first_row);
    const double condition = condition_of(W);
    if (!(condition < largest_condition)) {
      throw InputError("multisine: the inputs at " + std::to_string(response.frequencies_hz[l]) +
                       " Hz are no independent experiments (condition of W " +
                       std::to_string(condition) + "): is this the log of another excitation?");
    }
    response.input_condition(l) = condition;
    response.T.push_back(W.transpose().partialPivLu().solve(Y.transpose()).transpose());
    response.off_line_ratio(l) = off_line_norm(raster, window, bin, outputs, first_row) / Y.norm();
  }
  response.singular_values = singular_values(response.T);
  return response;
}

FrequencyResponse identify(const MultisinePlan& plan, const RunLog& log) {
  const double rate = log.info.sample_rate_hz;
  if (std::abs(plan.sample_rate_hz - rate) > 1e-9 * rate) {
    throw InputError("multisine: sample_rate_hz: found " + std::to_string(plan.sample_rate_hz) +
                     ", the log has " + std::to_string(rate));
  }
  const Raster raster = raster_of(plan);
  const Index needed = 1 + plan.n_blocks * (raster.ramp + raster.window);
  if (!log.measurements.gaps.empty() && log.measurements.gaps.front().first < needed) {
    throw InputError("multisine: sample " + std::to_string(log.measurements.gaps.front().first) +
                     " is not in the log; the plan needs the first " + std::to_string(needed) +
                     " without a gap");
  }
  return identify(plan, log.floor_acceleration, log.frame_acceleration, 1);
}

}  // namespace stillframe::report

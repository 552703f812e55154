#include "report/identification/multisine.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "core/errors/input_error.hpp"
#include "report/spectra/fourier.hpp"
#include "report/spectra/windows.hpp"

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

/// The steady parts of some signals, transformed: a matrix a block, bins x channels.
std::vector<MatrixXcd> transformed(const Raster& raster, const VectorXd& window,
                                   const MatrixXd& data, Index first_row) {
  std::vector<MatrixXcd> blocks;
  for (Index b = 0; b < raster.n_blocks; ++b) {
    const auto steady = data.middleRows(first_row + raster.start_of(b), raster.window);
    blocks.push_back(fourier(window.asDiagonal() * steady));
  }
  return blocks;
}

/// One bin of every channel in every block: channels x blocks.
MatrixXcd bin_of_blocks(const std::vector<MatrixXcd>& blocks, Index bin) {
  MatrixXcd result(blocks.front().cols(), static_cast<Index>(blocks.size()));
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    result.col(static_cast<Index>(b)) = blocks[b].row(bin).transpose();
  }
  return result;
}

/// Bins between the lines, around one of them: on either side the next two that are 2 bins or more
/// from every multiple of 4.
std::vector<Index> quiet_bins(Index bin, Index window) {
  std::vector<Index> bins;
  for (const Index distance : {2, 6}) {
    for (const Index quiet : {bin - distance, bin + distance}) {
      if (quiet >= 2 && quiet <= window / 2 - 2) bins.push_back(quiet);
    }
  }
  return bins;
}

double condition_of(const MatrixXcd& W) {
  const VectorXd sigma = Eigen::JacobiSVD<MatrixXcd>(W).singularValues();
  return sigma(0) / sigma(sigma.size() - 1);
}

/// Beyond this the inputs of the blocks are one and the same experiment; the plan's own are at 1.
constexpr double largest_input_condition = 1e6;

bool is_lost(const MatrixXd& inputs, const MatrixXd& outputs, Index row) {
  return !inputs.row(row).allFinite() || !outputs.row(row).allFinite();
}

[[noreturn]] void refuse_part(Index block, std::size_t missing, Index window,
                              const std::string& why) {
  throw InputError("multisine: the steady part of block " + std::to_string(block + 1) +
                   " has lost " + std::to_string(missing) + " of " + std::to_string(window) +
                   " samples, " + why);
}

/// Fills in the lost rows of one steady part from those a period away; answers how many.
Index fill_part(Index block, Index begin, Index window, MatrixXd& inputs, MatrixXd& outputs) {
  std::vector<Index> missing;
  for (Index row = begin; row < begin + window; ++row) {
    if (is_lost(inputs, outputs, row)) missing.push_back(row);
  }
  if (missing.empty()) return 0;
  if (static_cast<double>(missing.size()) > largest_lost_share * static_cast<double>(window)) {
    refuse_part(block, missing.size(), window,
                "allowed is one in " + std::to_string(std::lround(1 / largest_lost_share)));
  }
  const Index period = window / 4;
  if (period * 4 != window) {
    refuse_part(block, missing.size(), window,
                "and is not four whole periods to fill them in from");
  }
  // From what was there before anything is filled in.
  const auto n_missing = static_cast<Index>(missing.size());
  MatrixXd means(n_missing, inputs.cols() + outputs.cols());
  for (Index i = 0; i < n_missing; ++i) {
    int n = 0;
    means.row(i).setZero();
    const Index phase = (missing[static_cast<std::size_t>(i)] - begin) % period;
    for (Index row = begin + phase; row < begin + window; row += period) {
      if (is_lost(inputs, outputs, row)) continue;
      means.row(i).head(inputs.cols()) += inputs.row(row);
      means.row(i).tail(outputs.cols()) += outputs.row(row);
      ++n;
    }
    if (n == 0) refuse_part(block, missing.size(), window, "one of them in all four periods");
    means.row(i) /= n;
  }
  for (Index i = 0; i < n_missing; ++i) {
    const Index row = missing[static_cast<std::size_t>(i)];
    inputs.row(row) = means.row(i).head(inputs.cols());
    outputs.row(row) = means.row(i).tail(outputs.cols());
  }
  return n_missing;
}

}  // namespace

FrequencyResponse identify(const MultisinePlan& plan, const MatrixXd& inputs,
                           const MatrixXd& outputs, Index first_row) {
  const Raster raster = raster_of(plan);
  check_data(plan, raster, inputs, outputs, first_row);
  const VectorXd window = blackman_harris(raster.window), quiet_window = hann(raster.window);
  const auto W_all = transformed(raster, window, inputs, first_row);
  const auto Y_all = transformed(raster, window, outputs, first_row);
  const auto W_quiet = transformed(raster, quiet_window, inputs, first_row);
  const auto Y_quiet = transformed(raster, quiet_window, outputs, first_row);
  const double noise_ratio = window.squaredNorm() / quiet_window.squaredNorm();

  const auto n_lines = static_cast<Index>(raster.bins.size());
  FrequencyResponse response;
  response.frequencies_hz = plan.frequencies_hz;
  response.dof.resize(n_lines);
  response.input_condition.resize(n_lines);
  for (Index l = 0; l < n_lines; ++l) {
    const Index bin = raster.bins[static_cast<std::size_t>(l)];
    const MatrixXcd W = bin_of_blocks(W_all, bin), Y = bin_of_blocks(Y_all, bin);
    const double condition = condition_of(W);
    if (!(condition < largest_input_condition)) {
      throw InputError("multisine: the inputs at " + std::to_string(response.frequencies_hz[l]) +
                       " Hz are no independent experiments (condition of W " +
                       std::to_string(condition) + "): is this the log of another excitation?");
    }
    response.input_condition(l) = condition;
    const MatrixXcd T = W.transpose().partialPivLu().solve(Y.transpose()).transpose();
    MatrixXcd noise = MatrixXcd::Zero(T.rows(), T.rows());
    const std::vector<Index> quiet = quiet_bins(bin, raster.window);
    for (const Index q : quiet) {
      const MatrixXcd N = bin_of_blocks(Y_quiet, q) - T * bin_of_blocks(W_quiet, q);
      noise += N * N.adjoint();
    }
    response.dof(l) = static_cast<double>(quiet.size()) * static_cast<double>(raster.n_blocks);
    response.noise.push_back(noise * (noise_ratio / response.dof(l)));
    response.input_weight.push_back((W * W.adjoint()).inverse().conjugate());
    response.T.push_back(T);
    response.output_power.push_back(Y * Y.adjoint() / static_cast<double>(raster.n_blocks));
  }
  complete(response, 2 / (plan.sample_rate_hz * window.squaredNorm()));
  return response;
}

Index fill_lost_rows(const MultisinePlan& plan, MatrixXd& inputs, MatrixXd& outputs,
                     Index first_row) {
  const Raster raster = raster_of(plan);
  std::vector<bool> steady(static_cast<std::size_t>(inputs.rows()), false);
  Index n_filled = 0;
  for (Index b = 0; b < raster.n_blocks; ++b) {
    const Index begin = first_row + raster.start_of(b);
    if (begin + raster.window > inputs.rows()) break;  // identify() says so
    std::fill_n(steady.begin() + begin, raster.window, true);
    n_filled += fill_part(b, begin, raster.window, inputs, outputs);
  }
  for (Index row = 0; row < inputs.rows(); ++row) {
    if (steady[static_cast<std::size_t>(row)] || !is_lost(inputs, outputs, row)) continue;
    inputs.row(row).setZero();
    outputs.row(row).setZero();
  }
  return n_filled;
}

}  // namespace stillframe::report

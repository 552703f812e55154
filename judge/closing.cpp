#include "judge/closing.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "controller/excitation.hpp"
#include "controller/start_check.hpp"
#include "core/control/close_loop.hpp"
#include "core/control/fitting/acted_commands.hpp"
#include "core/control/fitting/rig_model.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double less = 0.8, of_limit = 0.5;
// Of a decibel and noise, that a law does more; of noise, 6 dB are anything from nothing on.
constexpr double clear = 2, most_doubt_db = 5;
constexpr Index n_axis = 400;

using Of = ClosedResponse::Of;

/// The plant with these outputs: accelerations of the scene, or forces a sample late.
SampledPlant with_outputs(SampledPlant plant, Of of, const std::vector<Index>& frame) {
  if (of != Of::frame) {
    plant.C_y = plant.C_sigma;
    plant.D_0 = plant.D_sigma;
    if (of == Of::strain) {
      plant.C_y -= plant.C_report;
      plant.D_0 -= plant.D_report;
    }
    plant.D_yu = MatrixXd::Zero(plant.D_sigma.rows(), plant.D_sigma.cols());
    plant.D_yw = MatrixXd::Zero(plant.C_sigma.rows(), plant.Gamma_w.cols());
    return plant;
  }
  for (MatrixXd* rows : {&plant.C_y, &plant.D_0, &plant.D_yu, &plant.D_yw}) {
    const MatrixXd all = *rows;
    rows->resize(static_cast<Index>(frame.size()), all.cols());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      rows->row(static_cast<Index>(i)) = all.row(frame[i]);
    }
  }
  return plant;
}

/// What was read of that; report_age: samples by which the applied force is read late.
MatrixXd outputs_of(const controller::Recording& recording, Of of, Index report_age) {
  if (of == Of::frame) return recording.frame;
  MatrixXd outputs = recording.sigma;
  if (of == Of::strain) {
    outputs.topRows(outputs.rows() - report_age) -=
        recording.applied.bottomRows(outputs.rows() - report_age);
  }
  return outputs;
}

/// Of a value that is known to so many dB, in a mean: none, where that is a guess.
double weight_of(double doubt_db) {
  constexpr double exact_db = 1e-6;
  return doubt_db < most_doubt_db ? 1 / (doubt_db * doubt_db + exact_db * exact_db) : 0;
}

double largest(const MatrixXcd& T) { return Eigen::JacobiSVD<MatrixXcd>(T).singularValues()(0); }

/// Of the forces that are added, at each line, n_out x m.
std::vector<MatrixXcd> transfers(const SampledPlant& plant, const DiscreteLaw& law,
                                 const VectorXd& omega) {
  const SampledLoop loop = close_loop_with_added_force(plant, law);
  std::vector<MatrixXcd> all;
  for (const double w : omega) {
    all.push_back(transfer(loop, w).rightCols(plant.Gamma_u.cols()));
  }
  return all;
}

VectorXd largest_of(const std::vector<MatrixXcd>& transfers) {
  VectorXd sizes(static_cast<Index>(transfers.size()));
  std::ranges::transform(transfers, sizes.begin(), largest);
  return sizes;
}

/// What was measured of the transfer matrices, in the whole and along what was predicted.
struct Measured {
  std::vector<MatrixXcd> mean;   ///< of each line, n_out x m
  std::vector<double> variance;  ///< of each line, of the means of its entries, their sum
  VectorXd along, along_noise;   ///< as in ClosedResponse
};

/// added: n x m, N, what acted beside what the law asked for.
Measured measured(const controller::ClosedRecording& run, const MatrixXd& added,
                  const MatrixXd& outputs, const std::vector<MatrixXcd>& predicted) {
  const controller::Recording& recording = run.recording;
  const std::vector<int>& lines = run.lines;
  const Index n_window = run.n_window;
  const fitting::LineKernel kernel(n_window, lines, 0);
  const auto n_lines = static_cast<Index>(lines.size());
  const Index m = recording.command.cols(), n_out = outputs.cols();
  Measured found{.mean = std::vector<MatrixXcd>(lines.size(), MatrixXcd::Zero(n_out, m)),
                 .variance = std::vector<double>(lines.size(), 0),
                 .along = VectorXd::Zero(n_lines),
                 .along_noise = VectorXd::Zero(n_lines)};
  std::vector<Eigen::JacobiSVD<MatrixXcd>> directions;
  for (const MatrixXcd& T : predicted) {
    directions.emplace_back(T, Eigen::ComputeThinU | Eigen::ComputeThinV);
  }
  for (Index leg = 0; leg < m; ++leg) {
    std::vector<MatrixXcd> each;  // of each window, n_out x lines
    for (std::size_t w = 0; w < recording.windows.size(); ++w) {
      if (recording.driven[w] != leg) continue;
      const Index from = recording.windows[w];
      const Eigen::RowVectorXcd drive =
          added.col(leg).segment(from, n_window).transpose() * kernel.powers;
      MatrixXcd of_window = outputs.middleRows(from + 1, n_window).transpose() * kernel.powers;
      of_window.array().rowwise() /= drive.array();
      each.push_back(std::move(of_window));
    }
    const auto n = static_cast<double>(each.size());
    for (Index l = 0; l < n_lines; ++l) {
      const auto k = static_cast<std::size_t>(l);
      for (const MatrixXcd& of_window : each) found.mean[k].col(leg) += of_window.col(l) / n;
      const Eigen::VectorXcd u = directions[k].matrixU().col(0);
      const double part = std::norm(directions[k].matrixV()(leg, 0));
      for (const MatrixXcd& of_window : each) {
        const Eigen::VectorXcd off = of_window.col(l) - found.mean[k].col(leg);
        found.variance[k] += off.squaredNorm() / (n * (n - 1));
        // Half of it turns the phase.
        found.along_noise(l) += part * std::norm(u.dot(off)) / (2 * n * (n - 1));
      }
    }
  }
  for (Index l = 0; l < n_lines; ++l) {
    const auto k = static_cast<std::size_t>(l);
    const double size = directions[k].singularValues()(0);
    found.along(l) = std::abs(directions[k].matrixU().col(0).dot(found.mean[k] *
                                                                 directions[k].matrixV().col(0))) /
                     size;
    found.along_noise(l) = std::sqrt(found.along_noise(l)) / size;
  }
  return found;
}

/// N, the largest command of a leg once a loop has settled that is excited by a multisine of peak
/// 1 N at these lines of a window of n samples, one leg after the other.
double largest_command(const LoopDesign& design, const std::vector<int>& lines, Index n_window) {
  SampledPlant plant = design.sampled;
  plant.C_y = plant.C_report;
  plant.D_0 = plant.D_report;
  plant.D_yu = MatrixXd::Zero(plant.D_report.rows(), plant.D_report.cols());
  plant.D_yw = MatrixXd::Zero(plant.C_report.rows(), plant.Gamma_w.cols());
  const SampledLoop loop = close_loop_with_added_force(plant, whole_law_of(design.settings));
  const Index m = plant.Gamma_u.cols();
  const auto n_lines = static_cast<Index>(lines.size());
  const fitting::LineKernel kernel(n_window, lines, 0);
  const Eigen::RowVectorXcd wave =
      controller::multisine(lines, n_window).transpose() * kernel.powers;
  std::vector<MatrixXcd> answers;
  for (Index l = 0; l < n_lines; ++l) {
    const double omega =
        two_pi * lines[static_cast<std::size_t>(l)] / static_cast<double>(n_window);
    answers.push_back(wave(l) * transfer(loop, omega / design.sampled.sample_time).rightCols(m));
  }
  double largest = 0;
  for (Index leg = 0; leg < m; ++leg) {
    MatrixXcd of_lines(m, n_lines);
    for (Index l = 0; l < n_lines; ++l) {
      of_lines.col(l) = answers[static_cast<std::size_t>(l)].col(leg);
    }
    // powers has 2 / n e^-i..., and a cosine's sum is its amplitude.
    const MatrixXd over_time =
        (of_lines * kernel.powers.adjoint()).real() * (static_cast<double>(n_window) / 2);
    largest = std::max(largest, over_time.cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

double added_force(double force_n, const LoopDesign& design, controller::Policy policy) {
  const double limit = controller::force_limit(design.gains, policy);
  policy.excitation.force_n = 0.5 * limit;
  const controller::Excitation plan(design.gains, policy);
  return std::min(less * force_n,
                  of_limit * limit / largest_command(design, plan.lines(), plan.n_window()));
}

double ClosedResponse::off_db(Index line) const {
  return decibels(measured(line)) - decibels(predicted(line));
}

double ClosedResponse::off_passive_db(Index line) const {
  return decibels(measured(line)) - decibels(passive(line));
}

double ClosedResponse::doubt_db(Index line) const {
  return decibels(1 + 2 * noise(line) / measured(line));
}

bool ClosedResponse::tells_law(Index line) const {
  const double law_db = decibels(predicted(line)) - decibels(passive(line));
  return std::abs(law_db) > clear * (most_db + doubt_db(line)) && doubt_db(line) < most_doubt_db;
}

Index ClosedResponse::worst() const {
  const auto beyond = [&](Index l) { return std::abs(off_db(l)) - doubt_db(l); };
  Index at = -1;
  for (Index l = 0; l < measured.size(); ++l) {
    if (is_told(l) && (at < 0 || beyond(l) > beyond(at))) at = l;
  }
  return at;
}

Index ClosedResponse::n_told() const {
  Index n = 0;
  for (Index l = 0; l < measured.size(); ++l) n += is_told(l);
  return n;
}

Index ClosedResponse::n_acting() const {
  Index n = 0;
  for (Index l = 0; l < measured.size(); ++l) {
    n += tells_law(l) && std::abs(off_passive_db(l)) > most_db + doubt_db(l);
  }
  return n;
}

double ClosedResponse::along_off_db(Index line) const { return decibels(along(line)); }

double ClosedResponse::along_doubt_db(Index line) const {
  return decibels(1 + 2 * along_noise(line) / along(line));
}

double ClosedResponse::mean_off_db() const {
  double sum = 0, weights = 0;
  for (Index l = 0; l < along.size(); ++l) {
    const double weight = weight_of(along_doubt_db(l));
    if (weight > 0) sum += weight * along_off_db(l);
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

double ClosedResponse::mean_doubt_db() const {
  double weights = 0;
  for (Index l = 0; l < along.size(); ++l) weights += weight_of(along_doubt_db(l));
  return weights > 0 ? 1 / std::sqrt(weights) : infinity;
}

bool ClosedResponse::is_as_predicted() const {
  if (!is_known() || !(std::abs(mean_off_db()) <= most_db + mean_doubt_db())) return false;
  for (Index l = 0; l < along.size(); ++l) {
    const double doubt = along_doubt_db(l);
    if (doubt <= most_db && !(std::abs(along_off_db(l)) <= most_db + doubt)) return false;
  }
  for (Index l = 0; l < measured.size(); ++l) {
    if (is_told(l) && !(std::abs(off_db(l)) <= most_db + doubt_db(l))) return false;
  }
  return n_acting() > 0;
}

namespace {

ClosedResponse closed_response(const controller::ClosedRecording& run, const MatrixXd& added,
                               const LoopDesign& design, Of of, const std::vector<Index>& frame) {
  ClosedResponse response;
  response.of = of;
  const auto n_lines = static_cast<Index>(run.lines.size());
  response.frequencies_hz.resize(n_lines);
  for (Index l = 0; l < n_lines; ++l) {
    response.frequencies_hz(l) = run.lines[static_cast<std::size_t>(l)] *
                                 design.gains.sample_rate_hz / static_cast<double>(run.n_window);
  }
  response.axis_hz = Eigen::ArrayXd::LinSpaced(n_axis, std::log(response.frequencies_hz(0)),
                                               std::log(response.frequencies_hz(n_lines - 1)))
                         .exp();
  const VectorXd omega = two_pi * response.frequencies_hz, axis = two_pi * response.axis_hz;
  const SampledPlant plant = with_outputs(design.sampled, of, frame);
  DiscreteLaw law = whole_law_of(design.settings);
  const std::vector<MatrixXcd> predicted = transfers(plant, law, omega);
  response.predicted = largest_of(predicted);
  response.predicted_axis = largest_of(transfers(plant, law, axis));
  law.C.setZero();
  law.D.setZero();
  response.passive = largest_of(transfers(plant, law, omega));
  response.passive_axis = largest_of(transfers(plant, law, axis));
  Measured found =
      measured(run, added, outputs_of(run.recording, of, design.sampled.report_age), predicted);
  response.along = std::move(found.along);
  response.along_noise = std::move(found.along_noise);
  response.measured = response.noise = VectorXd::Zero(n_lines);
  for (Index l = 0; l < n_lines; ++l) {
    const auto k = static_cast<std::size_t>(l);
    response.measured(l) = largest(found.mean[k]);
    response.noise(l) = std::sqrt(found.variance[k]);
  }
  return response;
}

}  // namespace

std::vector<ClosedResponse> closed_responses(const controller::ClosedRecording& run,
                                             const LoopDesign& design,
                                             const std::vector<Index>& frame) {
  const controller::Recording& recording = run.recording;
  // A loop is linear: where another command acted than it sent, the difference was added to it.
  const MatrixXd added =
      recording.command - run.sent +
      fitting::acted_commands(run.sent, recording.applied, recording.missing).command;
  return {closed_response(run, added, design, frame.empty() ? Of::sigma : Of::frame, frame),
          closed_response(run, added, design, Of::strain, frame)};
}

bool are_as_predicted(const std::vector<ClosedResponse>& responses) {
  return std::ranges::all_of(responses, &ClosedResponse::is_as_predicted);
}

}  // namespace stillframe::judge

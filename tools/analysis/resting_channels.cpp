#include "tools/analysis/resting_channels.hpp"

#include <algorithm>
#include <numbers>

#include "core/frequency_response.hpp"
#include "core/yaml/input_error.hpp"
#include "report/verdict/acceptance.hpp"
#include "tools/analysis/loop_between.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Fewer samples may rest by chance, and commands take up to 20 to act.
constexpr std::int64_t fewest = 50;

/// Largest |T| of each output and input.
Eigen::MatrixXd largest_gain(const SampledLoop& loop, const VectorXd& frequencies_hz) {
  Eigen::MatrixXd largest = Eigen::MatrixXd::Zero(loop.C.rows(), loop.B.cols());
  for (const double f : frequencies_hz) {
    largest = largest.cwiseMax(transfer(loop, 2 * std::numbers::pi * f).cwiseAbs());
  }
  return largest;
}

/// m/s^2, what the model makes of the floor and of forces at most, of outputs by name; what is only
/// rounding of a symmetric model is left out.
VectorXd expected_motion(const RunAnalysis& run, const std::vector<std::string>& outputs) {
  constexpr double rounding = 1e-6;  // of what moves the frame: far above that of any model
  const LoopDesign& design = *run.run.design;
  const auto& info = run.data.scan.info;
  FrequencyRange range = axis_of(design, design.gains.target_hz);
  range.highest_hz = std::min(range.highest_hz, 0.4 * info.sample_rate_hz);
  range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  const VectorXd hz = logarithmic_frequencies(range.lowest_hz, range.highest_hz, 50);
  const FollowedFloor floor =
      followed_floor(design, outputs, run.active(), std::vector<double>(hz.begin(), hz.end()));
  const Eigen::MatrixXd T = largest_gain(floor.loop, hz);
  VectorXd expected = VectorXd::Zero(T.rows());
  const auto add = [&](const VectorXd& by, double largest) {
    expected = expected.cwiseMax((by.array() > rounding * largest).select(by, 0));
  };
  const auto& inputs = run.data.scan.faults.floor;
  for (Index j = 0; j < std::min<Index>(T.cols(), std::ssize(inputs)); ++j) {
    const report::ChannelCourse& course = inputs[static_cast<std::size_t>(j)];
    if (course.n_other < fewest) continue;
    const double size = 0.5 * (course.highest - course.lowest);
    add(size * T.col(j), size);
  }
  if (!has_forces(design.scene)) return expected;
  const report::ForceModel forces = force_model(design, outputs, run.active());
  VectorXd peak = VectorXd::Zero(forces.loop.B.cols());
  for (std::int64_t k = 0; k + fewest < info.n_samples; ++k) {
    peak = peak.cwiseMax(forces.at(k).cwiseAbs());
  }
  const Eigen::MatrixXd G = largest_gain(forces.loop, hz);
  for (Index j = 0; j < G.cols(); ++j) {
    add(peak(j) * G.col(j), peak(j) * G.col(j).maxCoeff());
  }
  return expected;
}

}  // namespace

std::vector<std::string> resting_channels(const RunAnalysis& run) {
  const auto& names = run.data.scan.info.frame_names;
  const auto& frame = run.data.scan.faults.frame;
  std::vector<std::string> at_rest, result;
  for (std::size_t i = 0; i < std::min(names.size(), frame.size()); ++i) {
    if (frame[i].n >= fewest && frame[i].rests()) at_rest.push_back(names[i]);
  }
  if (at_rest.empty() || !run.run.design) return result;
  try {
    const VectorXd expected = expected_motion(run, at_rest);
    for (std::size_t i = 0; i < at_rest.size(); ++i) {
      if (expected(static_cast<Index>(i)) > report::least_acceleration) {
        result.push_back(at_rest[i]);
      }
    }
  } catch (const InputError&) {
    // The log is not of its scene's signals, which other checks tell.
  }
  return result;
}

std::vector<std::string> resting_forces(const RunAnalysis& run) {
  const auto& legs = run.data.scan.info.leg_names;
  const auto &applied = run.data.scan.faults.applied, &commanded = run.data.scan.faults.commanded;
  std::vector<std::string> result;
  for (std::size_t i = 0; i < std::min({legs.size(), applied.size(), commanded.size()}); ++i) {
    if (applied[i].n >= fewest && applied[i].rests() && commanded[i].n_other >= fewest) {
      result.push_back(legs[i]);
    }
  }
  return result;
}

}  // namespace stillframe::tools

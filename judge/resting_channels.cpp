#include "judge/resting_channels.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/loop_between.hpp"
#include "report/verdict/acceptance.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::VectorXd;
using report::ChannelCourse;
using report::Rest;
using report::RestingChannel;
using report::Variation;

namespace {

/// Channels that rested long enough to be looked at, and their names.
struct Candidates {
  std::vector<std::string> names;
  std::vector<const ChannelCourse*> courses;
};

bool has_rested(const ChannelCourse& course) { return course.rest.n > 0; }

/// Largest |T| of each output and input.
Eigen::MatrixXd largest_gain(const SampledLoop& loop, const VectorXd& frequencies_hz) {
  Eigen::MatrixXd largest = Eigen::MatrixXd::Zero(loop.C.rows(), loop.B.cols());
  for (const double f : frequencies_hz) {
    largest = largest.cwiseMax(transfer(loop, two_pi * f).cwiseAbs());
  }
  return largest;
}

/// What one cause, an input of the floor or a disturbance, does to the candidates.
struct Cause {
  VectorXd gain;                  ///< largest, to each
  double size = 0;                ///< of its course
  Variation moved = {};           ///< over the run
  std::vector<Variation> during;  ///< and in the rest of each
};

VectorXd frequencies(const RunAnalysis& run) {
  const LoopDesign& design = *run.run.design;
  FrequencyRange range = axis_of(design, design.gains.target_hz);
  range.highest_hz = std::min(range.highest_hz, 0.4 * run.data.scan.info.sample_rate_hz);
  range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  return logarithmic_frequencies(range.lowest_hz, range.highest_hz, 50);
}

void add_floor(const RunAnalysis& run, const Candidates& candidates, std::vector<Cause>& causes) {
  const VectorXd hz = frequencies(run);
  const LoopDesign& design = *run.run.design;
  // What may rest is not said to be dead.
  const FloorNodes nodes =
      run.run.nodes == FloorNodes::follow ? FloorNodes::follow : FloorNodes::rest;
  const SampledLoop loop = followed_floor(design, candidates.names, run.active(), nodes,
                                          std::vector<double>(hz.begin(), hz.end()))
                               .loop;
  const Eigen::MatrixXd T = largest_gain(loop, hz);
  const auto& inputs = run.data.scan.faults.floor;
  for (Index j = 0; j < std::min<Index>(T.cols(), std::ssize(inputs)); ++j) {
    const auto k = static_cast<std::size_t>(j);
    Cause cause{T.col(j), 0.5 * (inputs[k].highest - inputs[k].lowest), inputs[k].moved, {}};
    for (const ChannelCourse* course : candidates.courses) {
      // What a knock leaves behind is longer than the knock.
      cause.during.push_back(course->rests() ? Variation{inputs[k].moved.sum, inputs[k].n_since}
                                             : course->rest.during[k]);
    }
    causes.push_back(std::move(cause));
  }
}

void add_forces(const RunAnalysis& run, const Candidates& candidates, std::vector<Cause>& causes) {
  const report::ForceModel forces = force_model(*run.run.design, candidates.names, run.active());
  const Eigen::MatrixXd G = largest_gain(forces.loop, frequencies(run));
  const std::size_t first = causes.size();
  for (Index j = 0; j < G.cols(); ++j) {
    causes.push_back({.gain = G.col(j), .during = std::vector<Variation>(candidates.names.size())});
  }
  VectorXd last = forces.at(-1);
  for (std::int64_t k = 0; k + Rest::fewest < run.data.scan.info.n_samples; ++k) {
    const VectorXd now = forces.at(k);
    for (Index j = 0; j < G.cols(); ++j) {
      Cause& cause = causes[first + static_cast<std::size_t>(j)];
      cause.size = std::max(cause.size, std::abs(now(j)));
      const double change = std::abs(now(j) - last(j));
      cause.moved.sum += change;
      for (std::size_t i = 0; i < candidates.courses.size(); ++i) {
        const ChannelCourse& course = *candidates.courses[i];
        const bool inside = k >= course.rest.first_seq + Rest::settled && k < course.rest.last_seq;
        // From its first change on: what a blow leaves behind is longer than the blow.
        if (!course.rests() && (!inside || (change == 0 && cause.during[i].n == 0))) continue;
        cause.during[i].sum += change;
        ++cause.during[i].n;
      }
    }
    last = now;
  }
}

/// Whether candidate i is made to move by what happened in its rest.
bool should_move(const ChannelCourse& course, std::size_t i, const std::vector<Cause>& causes) {
  double expected = 0, inside = 0, all = 0;
  for (const Cause& cause : causes) {
    const double gain = cause.gain(static_cast<Index>(i));
    all += gain * cause.moved.sum;
    if (cause.during[i].n < Rest::fewest) continue;
    expected = std::max(expected, gain * cause.size);
    inside += gain * cause.during[i].sum;
  }
  if (!(expected > report::least_acceleration)) return false;
  return course.rests() || is_odd(course, inside, all - inside);
}

RestingChannel resting(const RunAnalysis& run, std::string name, const ChannelCourse& course) {
  if (course.rests()) return {std::move(name)};
  const double rate_hz = run.data.scan.info.sample_rate_hz;
  return {std::move(name),
          formatted("from %.6g to %.6g s", static_cast<double>(course.rest.first_seq) / rate_hz,
                    static_cast<double>(course.rest.last_seq) / rate_hz)};
}

void add_frame(const RunAnalysis& run, std::vector<RestingChannel>& result) {
  const auto& scan = run.data.scan;
  const auto& names = scan.info.frame_names;
  Candidates candidates;
  for (std::size_t i = 0; i < std::min(names.size(), scan.faults.frame.size()); ++i) {
    if (!has_rested(scan.faults.frame[i])) continue;
    candidates.names.push_back(names[i]);
    candidates.courses.push_back(&scan.faults.frame[i]);
  }
  if (candidates.names.empty()) return;
  std::vector<Cause> causes;
  add_floor(run, candidates, causes);
  if (has_forces(run.run.design->scene) && run.data.forces_unknown.empty()) {
    add_forces(run, candidates, causes);
  }
  for (std::size_t i = 0; i < candidates.names.size(); ++i) {
    if (should_move(*candidates.courses[i], i, causes)) {
      result.push_back(resting(run, candidates.names[i], *candidates.courses[i]));
    }
  }
}

/// Whether a channel rests while another one moves. index: of the other among all channels.
bool rests_beside(const ChannelCourse& course, const ChannelCourse& other, std::size_t index) {
  if (!has_rested(course)) return false;
  if (course.rests()) return other.n_other >= Rest::fewest;
  const Variation& during = course.rest.during[index];
  return during.n >= Rest::fewest && is_odd(course, during.sum, other.moved.sum - during.sum);
}

void add_floor_inputs(const RunAnalysis& run, std::vector<RestingChannel>& result) {
  const auto& scan = run.data.scan;
  const Scene& scene = run.run.design->scene;
  const auto &floor = scan.faults.floor, &frame = scan.faults.frame;
  const std::size_t first = floor.size() + 2 * scan.faults.applied.size();
  for (std::size_t j = 0; j < std::min(floor.size(), scene.inputs.size()); ++j) {
    const SceneSignal& input = scene.inputs[j];
    for (std::size_t i = 0; i < std::min(scan.info.frame_names.size(), frame.size()); ++i) {
      const SceneSignal& seen = signal_of(scene, scan.info.frame_names[i]);
      const bool is_same = input.quantity == Quantity::acceleration &&
                           seen.quantity == Quantity::acceleration && seen.node == input.node &&
                           std::abs(seen.direction.dot(input.direction)) > 1 - 1e-6;
      if (!is_same || frame[i].highest - frame[i].lowest < 2 * report::least_acceleration ||
          !rests_beside(floor[j], frame[i], first + i)) {
        continue;
      }
      result.push_back(resting(run, "floor input " + input.name, floor[j]));
      break;
    }
  }
}

}  // namespace

std::vector<RestingChannel> resting_channels(const RunAnalysis& run) {
  std::vector<RestingChannel> result;
  try {
    if (run.run.design) {
      add_frame(run, result);
      add_floor_inputs(run, result);
    }
  } catch (const InputError&) {
    // The log is not of its scene's signals, which other checks tell.
  }
  const report::SampleFaults& faults = run.data.scan.faults;
  const auto& legs = run.data.scan.info.leg_names;
  const std::size_t first = faults.floor.size() + 2 * faults.sigma.size() + faults.frame.size();
  double range = infinity;
  if (run.run.design && run.run.design->scene.instruments.force_sensors) {
    // The steps of its converter may end short of it.
    const auto& sensors = *run.run.design->scene.instruments.force_sensors;
    range = sensors.range - sensors.quantisation;
  }
  for (std::size_t i = 0; i < std::min(legs.size(), faults.sigma.size()); ++i) {
    const ChannelCourse& sigma = faults.sigma[i];
    const bool limited = !sigma.rests() && std::abs(sigma.rest.value) >= range;
    if (limited || faults.applied[i].n_other < Rest::fewest ||
        !rests_beside(sigma, faults.commanded[i], first + i)) {
      continue;
    }
    result.push_back(resting(run, "sigma of " + legs[i], sigma));
  }
  return result;
}

std::vector<RestingChannel> resting_forces(const RunAnalysis& run) {
  const report::SampleFaults& faults = run.data.scan.faults;
  const auto& legs = run.data.scan.info.leg_names;
  const std::size_t first = faults.floor.size() + 2 * faults.sigma.size() + faults.frame.size();
  std::vector<RestingChannel> result;
  for (std::size_t i = 0; i < std::min(legs.size(), faults.applied.size()); ++i) {
    if (rests_beside(faults.applied[i], faults.commanded[i], first + i)) {
      result.push_back(resting(run, legs[i], faults.applied[i]));
    }
  }
  return result;
}

}  // namespace stillframe::judge

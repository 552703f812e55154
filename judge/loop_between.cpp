#include "judge/loop_between.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <memory>
#include <variant>

#include "controller/law.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/directions.hpp"
#include "judge/response_prediction.hpp"
#include "plant_sim/force_courses.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;

SampledPlant plant_between(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                           const std::vector<std::string>& outputs) {
  std::vector<SceneSignal> in = inputs, out;
  for (const std::string& name : outputs) out.push_back(signal_of(design.scene, name));
  for (const SceneSignal& leg : leg_signals(*design.scene.controller)) {
    in.push_back(leg);
    out.push_back(leg);
  }
  const LoopPlant plant = loop_plant(linearise(design.scene, design.model, in, out),
                                     std::ssize(inputs), std::ssize(outputs));
  return sample_and_hold(plant, design.gains.sampling());
}

std::vector<SceneSignal> force_signals(const Scene& scene) {
  std::vector<SceneSignal> signals;
  for (const SceneDisturbance& disturbance : scene.disturbances) {
    SceneSignal signal;
    signal.name = disturbance.name;
    signal.place = disturbance.place;
    signal.node = disturbance.node;
    signal.quantity = Quantity::force;
    signal.direction = disturbance.direction;
    signals.push_back(signal);
  }
  return signals;
}

namespace {

/// Whether the first inputs of a plant are those that the floor's sensors read.
enum class Heard { floor, nothing };

DiscreteLaw law_with(const LoopDesign& design, Heard heard) {
  DiscreteLaw law = controller::law_from_gains(design.gains);
  if (heard == Heard::nothing) law.feed_forward = {};
  return law;
}

SampledLoop loop_around(const SampledPlant& plant, const LoopDesign& design, bool active,
                        Heard heard) {
  return active ? close_loop(plant, law_with(design, heard)) : open_loop(plant);
}

std::optional<report::LateLoop> late_loop(const SampledPlant& plant, const LoopDesign& design,
                                          const std::optional<report::Takeover>& takeover,
                                          Heard heard) {
  if (!takeover) return std::nullopt;
  return report::LateLoop{*takeover, gain_loop(plant, law_with(design, heard))};
}

}  // namespace

SampledLoop loop_between(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                         const std::vector<std::string>& outputs, bool active) {
  return loop_around(plant_between(design, inputs, outputs), design, active, Heard::nothing);
}

namespace {

/// Prescribed translations across the inputs of their nodes.
std::vector<SceneSignal> unmeasured_translations(const Scene& scene) {
  std::vector<SceneSignal> result;
  for (SceneSignal& signal : prescribed_translations(scene)) {
    std::vector<Eigen::Vector3d> known;
    const std::vector<SceneSignal>* lists[] = {&scene.inputs, &result};
    for (const auto* list : lists) {
      for (const SceneSignal& other : *list) {
        if (other.node != signal.node || other.quantity != Quantity::acceleration) continue;
        add_to(known, other.direction);
      }
    }
    signal.direction = across(signal.direction, known);
    if (!signal.direction.isZero(0)) result.push_back(signal);
  }
  return result;
}

}  // namespace

FollowedFloor followed_floor(const LoopDesign& design, const std::vector<std::string>& outputs,
                             bool active, FloorNodes nodes,
                             const std::vector<double>& frequencies_hz,
                             const std::optional<report::Takeover>& takeover) {
  // What is left in a bound of noise of a thousandth of the motion is no harm to it.
  constexpr double least_share = 1e-3;
  const std::vector<SceneSignal>& measured = design.scene.inputs;
  const std::vector<SceneSignal> beside = unmeasured_translations(design.scene);
  const Index n_w = std::ssize(measured), n_u = std::ssize(beside), n_y = std::ssize(outputs);
  const MatrixXd D_w = directions_of(measured);
  const MatrixXd to_floor = D_w.completeOrthogonalDecomposition().pseudoInverse();
  SampledPlant plant = plant_between(design, measured, outputs);
  FollowedFloor result{.loop = loop_around(plant, design, active, Heard::floor),
                       .late = {},
                       .rigid = D_w * to_floor,
                       .leans_on_rigid = std::vector<bool>(outputs.size(), false)};
  if (n_u > 0 && nodes != FloorNodes::rest) {
    std::vector<SceneSignal> all = measured;
    all.insert(all.end(), beside.begin(), beside.end());
    SampledPlant wide = plant_between(design, all, outputs);
    const SampledLoop loop = loop_around(wide, design, active, Heard::floor);
    Eigen::VectorXd by_measured = Eigen::VectorXd::Zero(n_y), by_others = by_measured;
    for (const double f : frequencies_hz) {
      const MatrixXd T = transfer(loop, two_pi * f).cwiseAbs();
      by_measured = by_measured.cwiseMax(T.leftCols(n_w).rowwise().maxCoeff());
      by_others = by_others.cwiseMax(T.rightCols(n_u).rowwise().maxCoeff());
    }
    bool leans = false;
    for (Index i = 0; i < n_y; ++i) {
      const bool leans_here = by_others(i) > least_share * by_measured(i);
      result.leans_on_rigid[static_cast<std::size_t>(i)] = leans_here;
      leans = leans || leans_here;
    }
    if (leans) {
      const MatrixXd others = directions_of(beside) * to_floor;
      for (MatrixXd* M : {&wide.Gamma_w, &wide.D_yw}) {
        *M = (M->leftCols(n_w) + M->rightCols(n_u) * others).eval();
      }
      plant = std::move(wide);
      result.loop = loop_around(plant, design, active, Heard::floor);
    }
  }
  if (active) result.late = late_loop(plant, design, takeover, Heard::floor);
  return result;
}

bool has_forces(const Scene& scene) {
  const auto acts = [](const SceneDisturbance& disturbance) {
    return std::visit(
        [](const auto& force) {
          if constexpr (requires { force.height; }) {
            return force.height != 0;
          } else if constexpr (requires { force.peak; }) {
            return force.peak != 0;
          } else if constexpr (requires { force.scale; }) {
            return force.scale != 0;
          } else {
            return true;
          }
        },
        disturbance.force);
  };
  return std::any_of(scene.disturbances.begin(), scene.disturbances.end(), acts);
}

report::ForceModel force_model(const LoopDesign& design, const std::vector<std::string>& outputs,
                               bool active, const std::optional<report::Takeover>& takeover) {
  auto courses = std::make_shared<std::vector<ForceCourse>>();
  for (const SceneDisturbance& disturbance : design.scene.disturbances) {
    courses->emplace_back(disturbance, design.gains.sample_time());
  }
  const SampledPlant plant = plant_between(design, force_signals(design.scene), outputs);
  report::ForceModel model{loop_around(plant, design, active, Heard::nothing),
                           [courses](std::int64_t k) {
                             Eigen::VectorXd forces(std::ssize(*courses));
                             for (Index i = 0; i < forces.size(); ++i) {
                               forces(i) = (*courses)[static_cast<std::size_t>(i)].at(k);
                             }
                             return forces;
                           }};
  if (active) model.late = late_loop(plant, design, takeover, Heard::nothing);
  return model;
}

}  // namespace stillframe::judge

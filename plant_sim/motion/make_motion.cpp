#include "plant_sim/motion/make_motion.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/two_pi.hpp"
#include "plant_sim/motion/adaptive_motion.hpp"
#include "plant_sim/motion/exponential_motion.hpp"
#include "plant_sim/motion/linear_motion.hpp"
#include "plant_sim/motion/nodal_plant_motion.hpp"
#include "plant_sim/motion/ode_motion.hpp"

namespace stillframe {

namespace {

/// At 24 dofs the exponential and the nodal method take the same time for the same error, at 150
/// the nodal one takes less than half and errs less (docs/speed_against_error.md); between the two
/// nothing was measured.
constexpr Index most_dofs_of_exponentials = 60;

/// What a step in minimal coordinates may err by, of the tolerance of the run, so that many of them
/// keep it: by the estimates of the explicit pair and of the exponential method errors of steps
/// add up to some ten times the tolerance in swings of a radian. The pair judges dofs that are
/// angles and lengths by one number, of which the levers of a frame make three times too much. The
/// estimate of the nodal method is one of order 5 for steps of order 9, and needs no such share
/// (docs/decisions/0025).
constexpr double exponential_share = 0.1, explicit_share = 0.03;

/// What an evaluation of the nodal method takes of the exponential method's
/// (docs/large_motion.md).
constexpr double nodal_weight = 0.6;

/// Highest frequency of the linear part times a part's duration up to which the exponential method
/// is trusted in large motion: what its sweeps may leave of a very fast mode is an acceleration
/// that it then takes for that of the motion. At 180 and 3e6 radians in a part random scenes were
/// off by per cents at 1e-6 (102000296, 101001150).
constexpr double most_exact = 100;

/// The same up to which explicit steps can be afforded beside a rotor, where `auto` has no other
/// method for large motion: some two stages for each radian.
constexpr double most_affordable = 50;

/// Whether the forces of the legs have the closed form that the linear answer counts with.
bool in_closed_form(const Drive& drive) {
  return !drive.actuators().lags() || drive.actuators().exponential();
}

}  // namespace

MotionChoice choose_method(const Scene& scene, const Model& model, const Drive& drive) {
  const PlantMethod stated = scene.simulation.method;
  const bool exact = stated == PlantMethod::linear || stated == PlantMethod::exponential;
  if (exact && !in_closed_form(drive)) {
    throw InputError(scene.simulation.place +
                     ": method: linear and exponential do without a rate limit of the actuators, "
                     "and without hysteresis behind a lag; take another, or 'auto'");
  }
  if (stated == PlantMethod::nodal && scene.modal_damping) {
    throw InputError(scene.simulation.place +
                     ": method: nodal lives on forces between neighbours, and modal_damping "
                     "couples all deformations; take another, or 'auto'");
  }
  if (stated != PlantMethod::automatic) return {stated, "the scene says so"};
  if (!in_closed_form(drive)) {
    return {scene.modal_damping ? PlantMethod::dormand_prince : PlantMethod::nodal,
            "the forces of the legs bend within a sample"};
  }
  if (model.n_d > most_dofs_of_exponentials && !scene.modal_damping) {
    return {PlantMethod::nodal, "more dofs than dense exponentials are good for"};
  }
  return {PlantMethod::exponential, "forces of the legs in closed form: the linear part is exact"};
}

std::unique_ptr<Motion> make_motion(const MergedScene& merged, const Model& model,
                                    MotionChoice& choice, const Drive& drive,
                                    const std::vector<double>& durations) {
  const Scene& scene = merged.scene;
  const NominalMotion nominal = nominal_motion(model);
  if (choice.method == PlantMethod::linear && nominal.moving()) {
    throw InputError(scene.simulation.place +
                     ": method: linear is small motion about rest, but the operating point of this "
                     "scene moves; take another, or 'auto'");
  }
  const double filter_rate = two_pi * scene.instruments.sensor_filter_hz;
  std::vector<SceneSignal> signals = scene.outputs;
  signals.insert(signals.end(), scene.monitors.begin(), scene.monitors.end());
  const FramePoints points(model, merged.carried, signals);
  const double tolerance = scene.simulation.relative_tolerance;
  // The nodal method keeps its tolerance of what a rotor's own points do (docs/scene.md), beside
  // which a frame may be quiet. What is only let go from rest is none.
  const bool automatic = scene.simulation.method == PlantMethod::automatic;
  const MotionState& state = nominal.state;
  const bool beside_rotor = automatic && (!state.q_d_dot.isZero(0) || !state.q_r_dot.isZero(0) ||
                                          !state.q_r_ddot.isZero(0));
  if (beside_rotor && choice.method == PlantMethod::nodal) {
    choice = in_closed_form(drive)
                 ? MotionChoice{PlantMethod::exponential, "the operating point moves"}
                 : MotionChoice{PlantMethod::dormand_prince,
                                "the operating point moves, and the forces of the legs bend "
                                "within a sample"};
  }
  const bool never_nodal = beside_rotor || scene.modal_damping;
  const auto equations = [&] {
    return MinimalEquations(model, nominal, drive.legs(), filter_rate);
  };
  const auto explicit_motion = [&](double fastest) {
    return std::make_unique<OdeMotion>(equations(), points, explicit_share * tolerance, fastest);
  };
  const auto nodal_motion = [&] {
    return std::make_unique<NodalPlantMotion>(model, nominal, points, drive.legs(), filter_rate,
                                              tolerance);
  };
  if (choice.method == PlantMethod::nodal) return nodal_motion();
  MinimalEquations minimal = equations();
  const Index size = minimal.size();
  LinearEquations linear(minimal, nominal, points);
  if (choice.method == PlantMethod::linear) {
    return std::make_unique<LinearMotion>(std::move(linear), minimal.stress_scale(),
                                          minimal.n_filtered(), drive, durations);
  }
  const double rate = spectral_radius(linear.A), fastest = rate * durations.front();
  if (choice.method == PlantMethod::dormand_prince) return explicit_motion(rate);
  if (automatic && fastest > most_exact && !never_nodal) {
    choice = {PlantMethod::nodal, "modes turn by more than a hundred radians in a sample"};
    return nodal_motion();
  }
  auto small = std::make_unique<ExponentialMotion>(std::move(minimal), std::move(linear), points,
                                                   exponential_share * tolerance, drive, durations);
  if (!automatic || (never_nodal && fastest > most_affordable)) return small;
  if (never_nodal) {
    return std::make_unique<AdaptiveMotion>(std::move(small), explicit_motion(rate), 1.0, size);
  }
  return std::make_unique<AdaptiveMotion>(std::move(small), nodal_motion(), nodal_weight, size);
}

}  // namespace stillframe

#include "plant_sim/motion/make_motion.hpp"

#include <numbers>

#include "core/yaml/input_error.hpp"
#include "plant_sim/motion/adaptive_motion.hpp"
#include "plant_sim/motion/exponential_motion.hpp"
#include "plant_sim/motion/linear_motion.hpp"
#include "plant_sim/motion/nodal_plant_motion.hpp"
#include "plant_sim/motion/ode_motion.hpp"

namespace stillframe {

namespace {

Scheme scheme_of(PlantMethod method) {
  switch (method) {
    case PlantMethod::fehlberg:
      return Scheme::fehlberg;
    case PlantMethod::runge_kutta:
      return Scheme::runge_kutta;
    case PlantMethod::implicit_runge_kutta:
      return Scheme::implicit_runge_kutta;
    case PlantMethod::adams:
      return Scheme::adams;
    case PlantMethod::bdf:
      return Scheme::bdf;
    default:
      return Scheme::dormand_prince;
  }
}

/// At 24 dofs the exponential and the nodal method take the same time for the same error, at 150
/// the nodal one takes less than half and errs less (docs/speed_against_error.md); between the two
/// nothing was measured.
constexpr Index most_dofs_of_exponentials = 60;

/// Whether the forces of the legs have the closed form that the linear answer counts with.
bool in_closed_form(const Drive& drive) {
  return !drive.actuators().lags() || drive.actuators().exponential();
}

}  // namespace

std::string method_name(PlantMethod method) {
  switch (method) {
    case PlantMethod::automatic:
      return "auto";
    case PlantMethod::linear:
      return "linear";
    case PlantMethod::exponential:
      return "exponential";
    case PlantMethod::dormand_prince:
      return "dormand_prince";
    case PlantMethod::fehlberg:
      return "fehlberg";
    case PlantMethod::runge_kutta:
      return "runge_kutta";
    case PlantMethod::implicit_runge_kutta:
      return "implicit_runge_kutta";
    case PlantMethod::adams:
      return "adams";
    case PlantMethod::bdf:
      return "bdf";
    case PlantMethod::nodal:
      return "nodal";
    case PlantMethod::ida:
      return "ida";
  }
  return "";
}

MotionChoice choose_method(const Scene& scene, const Model& model, const Drive& drive) {
  const PlantMethod stated = scene.simulation.method;
  const bool exact = stated == PlantMethod::linear || stated == PlantMethod::exponential;
  if (exact && !in_closed_form(drive)) {
    throw InputError(scene.simulation.place +
                     ": method: linear and exponential do without a rate limit of the actuators, "
                     "and without hysteresis behind a lag; take another, or 'auto'");
  }
  if (stated == PlantMethod::ida && scene.instruments.sensor_filter_hz > 0) {
    throw InputError(scene.simulation.place +
                     ": method: ida has no sensor filter; take another, or 'auto'");
  }
  if (stated != PlantMethod::automatic) return {stated, "the scene says so"};
  if (!in_closed_form(drive)) {
    return {PlantMethod::dormand_prince, "the forces of the legs bend within a sample"};
  }
  if (model.n_d > most_dofs_of_exponentials) {
    return {PlantMethod::nodal, "more dofs than dense exponentials are good for"};
  }
  return {PlantMethod::exponential, "forces of the legs in closed form: the linear part is exact"};
}

std::unique_ptr<Motion> make_motion(const MergedScene& merged, const Model& model,
                                    PlantMethod method, const Drive& drive,
                                    const std::vector<double>& durations) {
  const Scene& scene = merged.scene;
  const Equilibrium rest = solve_equilibrium(model);
  const double filter_rate = 2 * std::numbers::pi * scene.instruments.sensor_filter_hz;
  MinimalEquations equations(model, rest, drive.legs(), filter_rate);
  std::vector<SceneSignal> signals = scene.outputs;
  signals.insert(signals.end(), scene.monitors.begin(), scene.monitors.end());
  FramePoints points(model, merged.carried, signals);
  const SceneSimulation& simulation = scene.simulation;
  const auto settings = [&simulation](PlantMethod of) {
    return Integrator::Settings{.scheme = scheme_of(of),
                                .relative_tolerance = simulation.relative_tolerance,
                                .steps_per_part = simulation.steps_per_sample,
                                .jacobian = {}};
  };
  if (method == PlantMethod::linear || method == PlantMethod::exponential) {
    LinearEquations linear(equations, scene, rest, points);
    if (method == PlantMethod::linear) {
      return std::make_unique<LinearMotion>(std::move(linear), equations.stress_scale(),
                                            equations.n_filtered(), drive, durations);
    }
    auto small =
        std::make_unique<ExponentialMotion>(std::move(equations), std::move(linear), points,
                                            simulation.relative_tolerance, drive, durations);
    if (simulation.method != PlantMethod::automatic) return small;
    return std::make_unique<AdaptiveMotion>(
        std::move(small),
        std::make_unique<OdeMotion>(MinimalEquations(model, rest, drive.legs(), filter_rate),
                                    std::move(points), settings(PlantMethod::dormand_prince)),
        simulation.relative_tolerance);
  }
  if (method == PlantMethod::nodal || method == PlantMethod::ida) {
    return std::make_unique<NodalPlantMotion>(
        model, rest, std::move(points), drive.legs(), filter_rate, simulation.relative_tolerance,
        method == PlantMethod::ida ? nodal::Method::ida : nodal::Method::radau);
  }
  return std::make_unique<OdeMotion>(std::move(equations), std::move(points), settings(method));
}

}  // namespace stillframe

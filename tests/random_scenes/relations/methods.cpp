#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

#include "core/linear/sampled_loop.hpp"
#include "core/node_moves.hpp"
#include "core/worst.hpp"
#include "tests/random_scenes/loop_run.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

namespace {

struct Method {
  const char* name;
  PlantMethod method;
};

/// What rounding makes of a run: that of positions, of the size of the scene, in the stiffest leg
/// and in the fastest motion, and that of the forces that balance.
struct Rounding {
  double acceleration = 0, sigma = 0;

  Rounding(Case& scene, double fastest) {
    const Model& model = scene.model();
    double stiffest = 0, static_force = 0;
    for (const ModelElement& element : model.elements) {
      if (element.S.size() > 0) stiffest = std::max(stiffest, element.S.cwiseAbs().maxCoeff());
    }
    for (const SceneElement& element : scene.scene().elements) {
      static_force = std::max(static_force, worst_of(element.preload));
    }
    // Positions that satisfy conditions are known to some 1e-12 of the scene's size, what changes of
    // them from one sample to the next to some epsilon.
    const double eps = 100 * std::numeric_limits<double>::epsilon(), size = scene_size(model);
    acceleration = eps * size * fastest * fastest;
    sigma = 1e-12 * (size * stiffest + static_force);
  }
};

/// The rms of the error over the run, over that of the signals, of accelerations or of forces,
/// whichever is worse: what docs/scene.md says of relative_tolerance. Of what is `bound` of the
/// signals and less than rounding nothing is asked.
double error_of(const Signals& run, const Signals& reference, const Rounding& rounding,
                double bound) {
  const auto relative = [bound](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                double noise) {
    const double error = (a - b).norm(), of_noise = noise * std::sqrt(double(b.size()));
    return error <= of_noise ? 0.0 : error / (b.norm() + of_noise / bound);
  };
  return worst_of(relative(run.acceleration, reference.acceleration, rounding.acceleration),
                  relative(run.sigma, reference.sigma, rounding.sigma));
}

Scene by(Scene scene, PlantMethod method, double tolerance) {
  scene.simulation.method = method;
  scene.simulation.relative_tolerance = tolerance;
  return scene;
}

/// Fastest rate of the linear plant, 1/s.
double fastest(const tools::LoopDesign& design) {
  const LoopPlant& plant = design.settings.plant;
  const Index n = plant.A.rows() - plant.n_exogenous;
  return plant.A.topLeftCorner(n, n).eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

std::optional<Finding> check_methods(Case& scene, std::uint64_t) {
  if (!scene.has_loop() || !scene.floor()) return std::nullopt;
  const tools::LoopDesign& design = scene.design();
  const Scene& own = scene.scene();
  const double tolerance = own.simulation.relative_tolerance;
  // An unstable loop magnifies any difference: its plant is looked at without control.
  const bool active = design.radius < largest_stable_radius;
  const auto run = [&](PlantMethod method, double relative) {
    auto floor = floor::make_floor_source(*scene.floor());
    const Index n = floor->n_samples();
    return run_loop(by(own, method, relative), design, std::move(floor), n, active);
  };
  // The reference is of another formulation than what is judged by it, and a thousandth as wrong.
  const Signals nodal = run(PlantMethod::nodal, 1e-3 * tolerance);
  std::vector<Method> minimal = {{"auto", PlantMethod::automatic}};
  const bool smooth = std::isinf(own.instruments.force_rate_limit) &&
                      !(own.instruments.hysteresis && own.instruments.actuator_lag_hz > 0);
  if (smooth) minimal.push_back({"exponential", PlantMethod::exponential});
  // Explicit steps are bound by the fastest mode; where that takes hundreds of them in a sample
  // nobody would choose them.
  const bool mild = fastest(design) / own.controller->sample_rate_hz < 50;
  if (mild) minimal.push_back({"dormand_prince", PlantMethod::dormand_prince});
  Finding finding;
  const double bound = 30 * tolerance;  // what docs/scene.md promises
  const Rounding rounding(scene, fastest(design));
  for (const Method& method : minimal) {
    finding.take(error_of(run(method.method, tolerance), nodal, rounding, bound), bound, method.name);
  }
  if (smooth || mild) {
    const Signals reference =
        run(smooth ? PlantMethod::exponential : PlantMethod::dormand_prince, 1e-3 * tolerance);
    finding.take(error_of(run(PlantMethod::nodal, tolerance), reference, rounding, bound), bound, "nodal");
  }
  return finding;
}

}  // namespace stillframe::random_scenes

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/numerics/worst.hpp"
#include "core/systems/sampled_loop.hpp"
#include "tests/random_scenes/loop_run.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

namespace {

struct Method {
  const char* name;
  PlantMethod method;
};

/// The rms of the error over the run, over that of the signals, of accelerations or of forces,
/// whichever is worse: what docs/scene.md says of relative_tolerance. Of what is `bound` of the
/// signals and less than rounding nothing is asked.
double error_of(const Signals& run, const Signals& reference, const RunRounding& rounding,
                double bound) {
  const auto relative = [bound](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double noise) {
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

}  // namespace

std::optional<Finding> check_methods(Case& scene, std::uint64_t) {
  if (!scene.has_loop() || !scene.floor()) return std::nullopt;
  const judge::LoopDesign& design = scene.design();
  const Scene& own = scene.scene();
  const double tolerance = own.simulation.relative_tolerance;
  // An unstable loop magnifies any difference: its plant is looked at without control.
  const bool active = design.radius < largest_stable_radius;
  Finding finding;
  const long most = affordable_evaluations(scene);
  const Index all = run_samples(scene);
  const auto run = [&](PlantMethod method, double relative, Index n) {
    return run_loop(by(own, method, relative), design, floor::make_floor_source(*scene.floor()), n,
                    active, most);
  };
  std::vector<Method> minimal = {{"auto", PlantMethod::automatic}};
  const double stiffness = fastest_rate(scene) / own.controller->sample_rate_hz;
  const bool smooth = std::isinf(own.instruments.force_rate_limit) &&
                      !(own.instruments.hysteresis && own.instruments.actuator_lag_hz > 0);
  // Where a sample is hundreds of the fastest turns and nothing damps them, the estimate of the
  // exponential method is too small in large motion (docs/scene.md).
  const bool exact = smooth && stiffness < 500;
  if (exact) minimal.push_back({"exponential", PlantMethod::exponential});
  // Explicit steps are bound by the fastest mode: some two stages for each radian of it. Where that
  // takes a hundred in a sample nobody would choose them.
  const bool mild = !skips(finding, "dormand_prince", stiffness, 50);
  if (mild) minimal.push_back({"dormand_prince", PlantMethod::dormand_prince});
  // References are of another formulation than what is judged by them, and a hundredth as wrong: so
  // much of the bound is not known. In nodal coordinates a rotor accelerates, and that is what its
  // tolerance is of (docs/scene.md): there the explicit pair is the other one, of the same
  // coordinates but of no linear part.
  // Nor do dampers of modes have a place in nodal coordinates.
  const bool turning = scene.operating_point().moving(),
             never_nodal = turning || own.modal_damping.has_value();
  if (never_nodal && !mild) {
    finding.skipped = {turning ? "all methods beside a rotor" : "all methods of damped modes"};
    return finding;
  }
  constexpr double of_reference = 1e-2;
  const Signals reference = run(never_nodal ? PlantMethod::dormand_prince : PlantMethod::nodal,
                                of_reference * tolerance, all);
  if (too_short(finding, "the runs", reference.n_samples(), all)) return finding;
  const double bound = 30 * tolerance;  // what docs/scene.md promises
  const RunRounding rounding(scene);
  // Runs that become too dear are compared as far as they went.
  const auto judge = [&](const Method& method, Signals by_which) {
    const Signals found = run(method.method, tolerance, by_which.n_samples());
    const bool whole = found.n_samples() == by_which.n_samples();
    if (too_short(finding, method.name, found.n_samples(), by_which.n_samples())) return whole;
    by_which.shorten(found.n_samples());
    finding.take(error_of(found, by_which, rounding, bound), bound, method.name);
    return whole;
  };
  std::vector<std::string> ends;
  std::string ended;    // names
  bool passed = false;  // a method in these coordinates came to the end
  for (const Method& method : minimal) {
    try {
      const bool whole = judge(method, reference);
      passed = passed || (whole && method.method != PlantMethod::automatic);
    } catch (const std::runtime_error& error) {
      ends.push_back(error.what());
      ended += std::string(" ") + method.name;
    }
  }
  if (!ends.empty()) {
    // At a dead point the dofs no longer say where the frame is (docs/scene.md): there every method
    // in these coordinates ends that comes so far, and all of them at one sample; `auto` may have
    // gone over to the nodal one before.
    const auto when = [](const std::string& end) { return end.substr(0, end.find(" s")); };
    const auto same = [&](const std::string& end) { return when(end) == when(ends.front()); };
    if (ends.size() > 1 && !passed && std::all_of(ends.begin(), ends.end(), same)) {
      return finding.compared > 0 ? std::optional(finding) : std::nullopt;
    }
    finding.take(1, 0, ends.front() + ", by" + ended);
    return finding;
  }
  if ((exact || mild) && !never_nodal) {  // a reference is of no more use than as a method
    const Signals other = run(exact ? PlantMethod::exponential : PlantMethod::dormand_prince,
                              of_reference * tolerance, all);
    if (!too_short(finding, "the reference of nodal", other.n_samples(), all)) {
      judge({"nodal", PlantMethod::nodal}, other);
    }
  }
  return finding;
}

}  // namespace stillframe::random_scenes

#pragma once

#include <Eigen/Core>
#include <limits>

#include "tests/random_scenes/case.hpp"

namespace stillframe::random_scenes {

/// What a run showed, a row a sample: sigma of the legs (N), accelerations of outputs and monitors
/// (m/s^2), and forces of the law (N).
struct Signals {
  Eigen::MatrixXd sigma, acceleration, force;

  Index n_samples() const { return sigma.rows(); }
  /// Leaves so many samples.
  void shorten(Index n);
};

/// Runs a scene in this process for so many samples, as single-process runs do, with the law
/// (active) or with zero commands. Ends early, with fewer rows, in the sample in which the plant
/// has evaluated its equations so many times. Errors: as ClosedLoop; std::runtime_error where the
/// motion cannot go on.
Signals run_loop(const Scene& scene, const judge::LoopDesign& design,
                 std::unique_ptr<floor::FloorSource> floor, Index n_samples, bool active,
                 long most_evaluations = std::numeric_limits<long>::max());
/// On a floor that is given, inputs x samples, m/s^2.
Signals run_loop(const Scene& scene, const judge::LoopDesign& design, const Eigen::MatrixXd& floor,
                 bool active);

/// Samples of a run: as long as the scene states, else all that its floor has. Beside other floors
/// filtered noise rings out for some hundred times the run, at next to nothing.
Index run_samples(Case& scene);

/// How often a run may evaluate the equations of motion, for some two seconds of a processor at
/// most. Most runs take a hundredth of it; explicit steps at a tolerance of 1e-9, whose estimate
/// rounding is more than, take thousands in a sample, and minutes. A count, not a time, so that
/// what is compared is the same on every machine.
long affordable_evaluations(Case& scene);

/// A scene without what no linear model has: limits of force and rate, hysteresis, errors of
/// sensors, disturbances.
Scene without_nonlinear_instruments(Scene scene);

/// Fastest rate of the linear model, 1/s, of all its modes: the design may go without most of them.
double fastest_rate(Case& scene);

/// What rounding makes of a run (m/s^2, N): that of positions, of the size of the scene, in the
/// stiffest leg and in the fastest motion, and that of the forces that balance.
struct RunRounding {
  double acceleration = 0, sigma = 0;

  explicit RunRounding(Case& scene);
};

}  // namespace stillframe::random_scenes

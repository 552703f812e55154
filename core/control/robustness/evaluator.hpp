#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/control/discrete_law.hpp"
#include "core/control/feed_forward.hpp"
#include "core/control/robustness/parameters.hpp"
#include "core/systems/sampled_loop.hpp"

namespace stillframe::robustness {

/// What one plant does in the loop.
struct Outcome {
  enum class Verdict { stable, unstable, failed };
  Verdict verdict = Verdict::failed;
  std::string failure;  ///< why there is no such plant; the rest is not set then
  double radius = 0;    ///< spectral radius, 1
  double decay = 0;     ///< -ln(radius) / T_s, slowest decay of all, 1/s
  /// Least damping ratio -Re(s) / |s| of all poles, s = ln(z) / T_s; below 0 if unstable, 1.
  double damping = 0;
  // Of a stable loop, if asked for:
  Eigen::VectorXd gain;  ///< n_f, largest singular value of T(e^{j omega T_s}), 1
  /// n_f, at each frequency the largest of T there and at the angles of the poles that are nearer
  /// to it than to its neighbours (by their ratio), 1: a resonance is narrower than any grid.
  Eigen::VectorXd highest;
  double peak = 0;  ///< largest of those, at a resonance refined, 1
};

/// The frequencies at which outcomes are kept: evenly spaced on a logarithmic axis, 10 a decade,
/// from a fiftieth of the target to 0.45 of the sample rate, rounded to three digits, and 1, 2, 5,
/// 10, 20, 50 and 100 Hz as far as they are below half the sample rate. Ascending, Hz.
Eigen::VectorXd outcome_frequencies_hz(double target_hz, double sample_rate_hz);

/// Least of -Re(ln z) / |ln z| over poles z; poles at 0, which are gone after one sample, count
/// as 1.
double least_damping(const Eigen::VectorXcd& poles);

/// One sampled law on many plants. The law is that of the unperturbed scene and is never
/// redesigned. Set-up. Calls of several threads at once are allowed.
class Evaluator {
 public:
  struct Settings {
    Scene scene;  ///< with a controller
    Sampling sampling;
    DiscreteLaw law;
    FeedForward feed_forward = {};      ///< beside the law; empty: none
    std::vector<Parameter> parameters;  ///< p
    Eigen::VectorXd frequencies_hz;     ///< n_f, below half the sample rate
  };
  enum class Want { poles, poles_and_gain };

  explicit Evaluator(Settings settings) : settings_(std::move(settings)) {}

  /// The plant at a value (-1 to 1) of each parameter: perturbed scene, equilibrium, linear model,
  /// sampled plant, closed loop. A plant without equilibrium or without a linear model is an
  /// outcome too. Errors: std::invalid_argument on the number of values.
  Outcome operator()(const Eigen::VectorXd& values, Want want = Want::poles_and_gain) const;

  /// The largest singular value of T of a stable plant at the given frequencies and, with
  /// with_resonances, at those that show its own resonances, between these too. Errors: those of
  /// the plant where there is none.
  struct Curve {
    Eigen::VectorXd frequencies_hz, gain;
  };
  Curve curve(const Eigen::VectorXd& values, const Eigen::VectorXd& frequencies_hz,
              bool with_resonances) const;

  const std::vector<Parameter>& parameters() const { return settings_.parameters; }
  const Eigen::VectorXd& frequencies_hz() const { return settings_.frequencies_hz; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(settings_.parameters.size()); }

 private:
  /// The loop without its feed-forward, for whose force there are further inputs then.
  SampledLoop loop_of(const Eigen::VectorXd& values) const;
  SampledPlant plant_of(const Eigen::VectorXd& values) const;
  Settings settings_;
};

}  // namespace stillframe::robustness

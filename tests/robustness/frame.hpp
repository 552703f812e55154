#pragma once

#include <string>

#include "core/control/design/control_loop.hpp"
#include "core/control/robustness/evaluator.hpp"

namespace stillframe::robustness {

/// The metrology frame with its controller, and what its gains give.
struct FrameLoop {
  FrameLoop();

  Scene scene;
  Sampling sampling;
  DiscreteLaw law;

  /// The law of this frame on plants of that uncertainty.
  Evaluator evaluator(const SceneUncertainty& uncertainty) const;
};

/// Text of the metrology frame without its floor and its controller.
std::string frame_text();

/// `text` with the only occurrence of `from` changed. Fails the test if there is not exactly one.
std::string with(std::string text, const std::string& from, const std::string& to);

/// 1, -1 or 0 for one parameter, 0 for all others.
Eigen::VectorXd only(Eigen::Index p, Eigen::Index j, double value);

/// A mass m on one leg of stiffness k, with the law u[k] = -kappa sigma[k], no delay.
struct Cart {
  double m = 2, k = 800, kappa = 0.5, sample_time = 0.01;

  Evaluator evaluator(const SceneUncertainty& uncertainty) const;
  /// Spectral radius in closed form, with the actuator's true gain g: from (e, e'/omega, u[k-1]),
  ///   u = -kappa (k e + g u[k-1]), e'' = -omega^2 e - g u / m held over a sample.
  double radius(double g) const;
};

}  // namespace stillframe::robustness

#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/control/feed_forward.hpp"
#include "core/control/loop_settings.hpp"

namespace stillframe {

/// What a feed-forward is to reach, and what it must not cost.
struct FeedForwardWeights {
  double to_hz = 0;      ///< up to here T is to be the goal
  double corner_hz = 0;  ///< below here the floor's sensors are not believed
  double at_most = 0.3;  ///< 1, |T| that is aimed at from 1.5 to_hz on: there what is won is paid
  double actuator_error = 0.02;    ///< relative, of the forces of all legs
  double noise_over_floor = 1e-3;  ///< density of the floor sensors' noise over the floor's
  Eigen::Index n_taps = 16;
};

/// The feed-forward F of least
///   sum over f of (|T - G|^2 + |e dT/dg|^2 + |nu H F|^2) / b^2,   T = T_fb + H F,
/// in the Frobenius norm, on a logarithmic grid of frequencies up to half the rate: T of the exact
/// sampled loop, H from the feed-forward's force to the outputs in it, G the goal up to to_hz and
/// zero above, b its size up to there and at_most from half as high again on, e = actuator_error, g
/// the force of all legs over the one that is commanded, nu the sensors' noise over the floor,
/// which rises as 1 / f^2 below the corner. Where legs outnumber motions, of all with that effect
/// the one of least weights. goal: n_y x p at omega (rad/s). Source:
/// docs/decisions/0030-floor-feed-forward.md. Set-up. Errors: as close_loop; std::invalid_argument
/// if the goal has other sizes than T.
FeedForward design_feed_forward(LoopSettings loop,
                                const std::function<Eigen::MatrixXcd(double)>& goal,
                                const FeedForwardWeights& weights);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/control/discrete_law.hpp"
#include "core/systems/sampled_loop.hpp"

namespace stillframe {

/// The closed loop of a sampled plant and a law. A feed-forward hears the first inputs w of the
/// plant, and nothing where the plant has none; its states are exogenous. Source: THEORY section 5.
/// Errors: std::invalid_argument on shapes that do not match.
SampledLoop close_loop(const SampledPlant& plant, const DiscreteLaw& law);

/// The same loop with m inputs more behind w: forces that are added to what the law commands, in
/// the sample that it answers. Any feed-forward is left out: it is such a force.
SampledLoop close_loop_with_added_force(SampledPlant plant, DiscreteLaw law);

/// A closed loop whose law may act by a share g of its command: A, B_v, C and D_v are then
/// (1 - g) released + g closed, B and D are the same.
struct GainedLoop {
  SampledLoop closed;    ///< as close_loop
  SampledLoop released;  ///< in the same states: commands are zero, but the law goes on
  /// What the law hears of the force sensors: e[k] = C_e xi[k] + v[k], less what it takes out.
  Eigen::MatrixXd C_e;
  Eigen::Index n_plant = 0;  ///< leading states that do not need the law's command: the plant's and
                             ///< the exogenous ones

  SampledLoop at(double share) const;
};

/// Errors: as close_loop.
GainedLoop gain_loop(const SampledPlant& plant, const DiscreteLaw& law);

/// Return ratio L(e^{j omega T_s}) at the actuators: with the loop cut between the command, which
/// is also reported, and the force that acts, and f put in there, the law commands c = -L f; m x m.
/// The closed loop is that of f = c. omega in rad/s.
Eigen::MatrixXcd return_ratio(const SampledPlant& plant, const DiscreteLaw& law, double omega);

}  // namespace stillframe

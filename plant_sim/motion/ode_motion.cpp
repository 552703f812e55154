#include "plant_sim/motion/ode_motion.hpp"

#include <algorithm>

#include "plant_sim/motion/state_in_words.hpp"

namespace stillframe {

using Eigen::VectorXd;

OdeMotion::OdeMotion(MinimalEquations equations, FramePoints points, Integrator::Settings settings)
    : equations_(std::move(equations)),
      points_(std::move(points)),
      // Preloads balance up to rounding only. Errors of that size can be met by no step, so they
      // set the least acceleration that counts.
      relative_tolerance_(settings.relative_tolerance),
      least_scale_(100 * equations_.rest_acceleration() / settings.relative_tolerance),
      integrator_(
          equations_.n_d(),
          [this](double t, const Eigen::Ref<const VectorXd>& y, Eigen::Ref<VectorXd> dy_dt) {
            return equations_.evaluate(*drive_, t, y, dy_dt);
          },
          with_jacobian(std::move(settings)), equations_.n_filtered()),
      y_(VectorXd::Zero(equations_.size())),
      rate_(y_) {}

Integrator::Settings OdeMotion::with_jacobian(Integrator::Settings settings) {
  settings.jacobian = [this](double t, const Eigen::Ref<const VectorXd>& y, Eigen::MatrixXd& J) {
    return equations_.evaluate(*drive_, t, y, rate_) && equations_.jacobian(J);
  };
  return settings;
}

Motion::Status OdeMotion::advance(const Drive& drive, double duration) noexcept {
  drive_ = &drive;
  // The accelerations at the end of what was before scale the error of this part; after rest they
  // are zero, and those under the whole command do.
  if (equations_.q_d_ddot().isZero(0) && !equations_.evaluate(drive, 0.0, y_, rate_)) {
    return Status::equations_failed;
  }
  // Positions are found to 1e-30 (core/kinematics): no step meets a finer error either.
  const double finest = 1e-29 / (duration * duration * relative_tolerance_);
  const double scale =
      std::max({equations_.q_d_ddot().lpNorm<Eigen::Infinity>(), least_scale_, finest});
  switch (integrator_.advance(y_, duration, scale)) {
    case Integrator::Status::right_hand_side_failed:
      return Status::equations_failed;
    case Integrator::Status::too_many_steps:
      return Status::too_many_steps;
    case Integrator::Status::failed:
      return Status::failed;
    case Integrator::Status::ok:
      break;
  }
  return equations_.evaluate(drive, duration, y_, rate_) ? Status::ok : Status::equations_failed;
}

void OdeMotion::velocities(VectorXd& v) const noexcept {
  points_.velocities(equations_.data().x, equations_.data().x_dot, v);
}

void OdeMotion::elastic_stresses(VectorXd& sigma) const noexcept {
  for (Index i = 0; i < equations_.n_legs(); ++i) sigma(i) = equations_.elastic_stress(i);
}

void OdeMotion::filtered_stresses(VectorXd& sigma) const noexcept {
  sigma = equations_.stress_scale() * y_.tail(equations_.n_filtered());
}

std::string OdeMotion::where() const { return state_in_words(y_, equations_.n_d()); }

}  // namespace stillframe

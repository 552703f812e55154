#include "plant_sim/motion/ode_motion.hpp"

#include <algorithm>
#include <cmath>

namespace stillframe {

using Eigen::VectorXd;

namespace {

/// Radians of a mode, beyond which its acceleration has turned round. An explicit step is no longer
/// anyhow.
constexpr double one_way = 3;

}  // namespace

OdeMotion::OdeMotion(MinimalEquations equations, FramePoints points, double relative_tolerance,
                     double fastest)
    : equations_(std::move(equations)),
      points_(std::move(points)),
      // In the mean square of N entries, which is what a step is judged by, one may be sqrt(N) out.
      relative_tolerance_(relative_tolerance / std::sqrt(static_cast<double>(equations_.size()))),
      // Preloads balance up to rounding only. Errors of that size can be met by no step, so they
      // set the least acceleration that counts.
      least_scale_(10 * equations_.rest_acceleration() / relative_tolerance_),
      longest_(one_way / fastest),
      integrator_(
          equations_.n_d(),
          [this](double t, const Eigen::Ref<const VectorXd>& y, Eigen::Ref<VectorXd> dy_dt) {
            if (t < last_t_) equations_.go_back();  // from a step that was not accepted
            last_t_ = t;
            return equations_.evaluate(*drive_, t, y, dy_dt);
          },
          relative_tolerance_, equations_.n_filtered()),
      y_(equations_.start()),
      rate_(y_) {}

Motion::Status OdeMotion::advance(const Drive& drive, double duration) noexcept {
  drive_ = &drive;
  last_t_ = 0;
  // The largest of two accelerations scales the error of this part: that at the end of what was
  // before, and that under the inputs at the end of this one, which a force that begins to rise
  // here from rest has as well. The floor has gone on there, and y has not.
  const double before = equations_.q_d_ddot().lpNorm<Eigen::Infinity>();
  n_looks_ += 2;
  if (!equations_.look(drive, duration, y_, rate_) && !equations_.look(drive, 0.0, y_, rate_)) {
    return Status::equations_failed;
  }
  // Positions are found to 1e-30 (core/mechanics/kinematics): no step meets a finer error either.
  const double finest = 1e-29 / (duration * duration * relative_tolerance_);
  const double acceleration =
      std::max({before, equations_.q_d_ddot().lpNorm<Eigen::Infinity>(), least_scale_, finest});
  const Status status =
      integrator_.advance(y_, duration, acceleration, std::min(duration, longest_));
  if (status != Status::ok) return status;
  if (!equations_.evaluate(drive, duration, y_, rate_)) return Status::equations_failed;
  equations_.keep();
  return Status::ok;
}

bool OdeMotion::hand_over(const Drive& drive, MotionSnapshot& to) noexcept {
  return equations_.hand_over(drive, y_, to);
}

void OdeMotion::take_over(const MotionSnapshot& from) noexcept {
  y_ = from.y;
  equations_.take_over(from);
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

Eigen::VectorXd OdeMotion::displacements() const { return y_.head(equations_.n_d()); }

}  // namespace stillframe

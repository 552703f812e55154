#include "plant_sim/motion/linear_motion.hpp"

#include <algorithm>

namespace stillframe {

LinearMotion::LinearMotion(LinearEquations equations, double stress_scale, Index n_filtered,
                           const Drive& drive, const std::vector<double>& durations)
    : equations_(std::move(equations)),
      stress_scale_(stress_scale),
      n_filtered_(n_filtered),
      strains_(!equations_.S_p.isZero(0) || !equations_.S_v.isZero(0)),
      start_(start_for(drive)),
      end_(start_),
      y_(Eigen::VectorXd::Zero(equations_.A.rows())),
      next_(y_) {
  for (const double duration : durations) step(drive, duration);
}

const LinearStep& LinearMotion::step(const Drive& drive, double duration) {
  const auto found = std::find_if(steps_.begin(), steps_.end(),
                                  [duration](const LinearStep& s) { return s.tau() == duration; });
  if (found != steps_.end()) return *found;
  return steps_.emplace_back(equations_, duration, drive.actuators().rate());
}

Motion::Status LinearMotion::advance(const Drive& drive, double duration) noexcept {
  gather(drive, 0, start_);
  step(drive, duration).apply(drive, start_, y_, next_);
  y_.swap(next_);
  drive.floor().floor_at(duration, end_.q_r, end_.q_r_dot);
  return y_.allFinite() ? Status::ok : Status::equations_failed;
}

void LinearMotion::velocities(Eigen::VectorXd& v) const noexcept {
  v.noalias() = equations_.V_y * y_;
  v.noalias() += equations_.V_r * end_.q_r_dot;
}

void LinearMotion::elastic_stresses(Eigen::VectorXd& sigma) const noexcept {
  sigma.noalias() = equations_.S_y * y_;
  if (!strains_) return;
  sigma.noalias() += equations_.S_p * end_.q_r;
  sigma.noalias() += equations_.S_v * end_.q_r_dot;
}

void LinearMotion::filtered_stresses(Eigen::VectorXd& sigma) const noexcept {
  sigma = stress_scale_ * y_.tail(n_filtered_);
}

Eigen::VectorXd LinearMotion::displacements() const {
  return y_.head((y_.size() - n_filtered_) / 2);
}

}  // namespace stillframe

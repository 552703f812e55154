#include "plant_sim/nodal/nodal_motion.hpp"

#include <algorithm>
#include <utility>

namespace stillframe::nodal {

NodalMotion::NodalMotion(const Model& model, const Data& start, double relative_tolerance,
                         Index stages)
    : relative_tolerance_(relative_tolerance),
      equations_(model),
      consistency_(equations_),
      solver_(equations_, relative_tolerance, stages),
      state_(equations_.zero_state()),
      before_(state_) {
  state_.x = start.x;
  state_.x_dot = start.x_dot;
  equations_.set_turns(start.e);
}

void NodalMotion::take_over(const Eigen::VectorXd& x, const Eigen::VectorXd& x_dot,
                            const Eigen::VectorXd& filtered,
                            const Eigen::VectorXd& turns) noexcept {
  state_.x = x;
  state_.x_dot = x_dot;
  equations_.set_turns(turns);
  consistent_ = false;
  solver_.forget();
  if (!solver_.low_pass()) return;
  filtered_ = filtered;
  solver_.low_pass()->set(filtered);
  filters_started_ = true;
}

void NodalMotion::filter(std::vector<Index> rows, double rate) {
  filtered_ = Eigen::VectorXd::Zero(static_cast<Index>(rows.size()));
  solver_.filter(std::move(rows), rate);
  filters_started_ = false;
}

/// The accelerations with the inputs as they are after the jump.
Status NodalMotion::begin(const Inputs& inputs) noexcept {
  equations_.take_inputs(inputs, 0, state_);
  equations_.count_turns_from(state_);
  const bool placed = consistent_ || (consistency_.positions(state_) && consistency_.rates(state_));
  if (!placed || !consistency_.accelerations(state_)) return Status::equations_failed;
  if (!rounding_known_) {
    // Preloads balance up to rounding only. Errors of that size can be met by no step, so they set
    // the least acceleration that counts.
    least_scale_ = 10 * consistency_.measure_rounding(state_) / relative_tolerance_;
    rounding_known_ = true;
  }
  if (solver_.low_pass()) {
    // The elastic stresses do not jump with the inputs, so that they are those of rest here.
    if (!filters_started_) {
      solver_.low_pass()->start_at(sigma(), sigma_a());
      filtered_ = solver_.low_pass()->state();
    }
    filters_started_ = true;
  }
  return Status::ok;
}

Status NodalMotion::finish(const Inputs& inputs, double duration) noexcept {
  equations_.take_inputs(inputs, duration, state_);
  if (!consistency_.positions(state_) || !consistency_.rates(state_) ||
      !consistency_.accelerations(state_)) {
    return Status::equations_failed;
  }
  consistent_ = true;
  if (solver_.low_pass()) filtered_ = solver_.low_pass()->state();
  return Status::ok;
}

Status NodalMotion::attempt(const Inputs& inputs, double duration) noexcept {
  Status status = begin(inputs);
  if (status != Status::ok) return status;
  const long steps = solver_.steps();
  status = solver_.advance(state_, inputs, duration, least_scale_);
  // Where it needs many steps, large displacements and stresses may round more than before.
  if (solver_.steps() - steps > 8) rounding_known_ = false;
  return status == Status::ok ? finish(inputs, duration) : status;
}

Status NodalMotion::advance(const Inputs& inputs, double duration) noexcept {
  before_ = state_;
  const auto go_back = [&] {
    state_ = before_;
    consistent_ = false;
    solver_.forget();
    if (solver_.low_pass()) solver_.low_pass()->set(filtered_);
  };
  Status status = attempt(inputs, duration);
  if (status == Status::failed) {
    const double least = least_scale_;
    go_back();
    rounding_known_ = false;
    status = begin(inputs);
    if (status == Status::ok && least_scale_ > least)
      status = attempt(inputs, duration);
    else if (status == Status::ok)
      status = Status::failed;
  }
  if (status != Status::ok) go_back();
  return status;
}

}  // namespace stillframe::nodal

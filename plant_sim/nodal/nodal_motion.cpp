#include "plant_sim/nodal/nodal_motion.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>
namespace stillframe::nodal {

NodalMotion::NodalMotion(const Model& model, const Data& start, double relative_tolerance,
                         Method method, Index stages)
    : relative_tolerance_(relative_tolerance),
      equations_(model),
      consistency_(equations_),
      state_(equations_.zero_state()),
      before_(state_) {
  if (method == Method::ida) {
    ida_ = std::make_unique<IdaSolver>(equations_, relative_tolerance);
  } else {
    radau_ = std::make_unique<RadauSolver>(equations_, relative_tolerance, stages);
  }
  state_.x = start.x;
  state_.x_dot = start.x_dot;
}

void NodalMotion::filter(std::vector<Index> rows, double rate) {
  if (!radau_) throw std::invalid_argument("NodalMotion: IDA does not carry filters along");
  filtered_ = Eigen::VectorXd::Zero(static_cast<Index>(rows.size()));
  radau_->filter(std::move(rows), rate);
  filters_started_ = false;
}

/// The accelerations with the inputs as they are after the jump.
Status NodalMotion::begin(const Inputs& inputs) noexcept {
  equations_.take_inputs(inputs, 0, state_);
  equations_.count_turns_from(state_);
  const bool first = !consistent_;
  if (first) {
    if (!consistency_.positions(state_)) return Status::position_not_found;
    if (!consistency_.rates(state_)) return Status::position_not_found;
  }
  if (!consistency_.accelerations(state_)) return Status::matrix_singular;
  if (first) {
    // Preloads balance up to rounding only. Errors of that size can be met by no step, so they set
    // the least acceleration that counts.
    least_scale_ = 10 * consistency_.measure_rounding(state_) / relative_tolerance_;
  }
  if (radau_ && radau_->low_pass()) {
    // The elastic stresses do not jump with the inputs, so that they are those of rest here.
    if (!filters_started_) radau_->low_pass()->start_at(sigma(), sigma_a());
    filters_started_ = true;
  }
  return Status::ok;
}

Status NodalMotion::finish(const Inputs& inputs, double duration) noexcept {
  equations_.take_inputs(inputs, duration, state_);
  if (!consistency_.positions(state_)) return Status::position_not_found;
  if (!consistency_.rates(state_)) return Status::position_not_found;
  if (!consistency_.accelerations(state_)) return Status::matrix_singular;
  consistent_ = true;
  if (radau_ && radau_->low_pass()) filtered_ = radau_->low_pass()->state();
  return Status::ok;
}

Status NodalMotion::advance(const Inputs& inputs, double duration) noexcept {
  before_ = state_;
  Status status = begin(inputs);
  if (status == Status::ok) {
    const double a = std::max(state_.x_ddot.lpNorm<Eigen::Infinity>(), least_scale_);
    const ErrorScale scale{a * duration * duration, a * duration};
    status = radau_ ? radau_->advance(state_, inputs, duration, scale)
                    : ida_->advance(state_, inputs, duration, scale);
  }
  if (status == Status::ok) status = finish(inputs, duration);
  if (status != Status::ok) {
    state_ = before_;
    consistent_ = false;
    if (radau_ && radau_->low_pass()) radau_->low_pass()->set(filtered_);
  }
  return status;
}

long NodalMotion::evaluations() const noexcept {
  return radau_ ? radau_->evaluations() : ida_->evaluations();
}
long NodalMotion::steps() const noexcept { return radau_ ? radau_->steps() : ida_->steps(); }

}  // namespace stillframe::nodal

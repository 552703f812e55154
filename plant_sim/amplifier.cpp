#include "plant_sim/amplifier.hpp"

#include <stdexcept>

#include "core/linear/smooth_step.hpp"

namespace stillframe {

using Eigen::VectorXd;

Amplifier::Amplifier(Eigen::Index n_legs, std::int64_t hold_samples, double fade_s,
                     double sample_time)
    : hold_samples_(hold_samples),
      sample_time_(sample_time),
      fade_s_(fade_s),
      force_(VectorXd::Zero(n_legs)),
      held_(force_),
      difference_(force_) {
  if (hold_samples < 0 || !(fade_s > 0) || !(sample_time > 0)) {
    throw std::invalid_argument("Amplifier: a hold of 0 samples or more and times above 0");
  }
}

const VectorXd& Amplifier::drive(const Eigen::Ref<const VectorXd>& command,
                                 std::int64_t n_missing) noexcept {
  if (n_missing > 0) {
    faded_ |= n_missing > hold_samples_;
    force_ = faded_ ? left(n_missing - hold_samples_) * held_ : held_;
    return force_;
  }
  if (faded_) {
    faded_ = false;
    difference_ = force_ - command;
    since_ = 0;
  }
  force_ = command + left(++since_) * difference_;
  held_ = force_;
  return force_;
}

double Amplifier::left(std::int64_t n_samples) const noexcept {
  return 1 - smooth_step(static_cast<double>(n_samples) * sample_time_ / fade_s_);
}

}  // namespace stillframe

#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "plant_sim/motion/exponential_motion.hpp"
#include "plant_sim/motion/ode_motion.hpp"

namespace stillframe {

/// The exponential method, until the motion is so large that its linear part is of no use and its
/// parts are halved again and again: where it needs more evaluations in most parts than an explicit
/// method would, that one soon goes on from the same state. A scene does not say beforehand how far
/// it will swing.
class AdaptiveMotion final : public Motion {
 public:
  /// Both at rest in the same equilibrium, on the same model, at the same tolerance.
  AdaptiveMotion(std::unique_ptr<ExponentialMotion> small, std::unique_ptr<OdeMotion> large,
                 double relative_tolerance)
      : small_(std::move(small)),
        large_(std::move(large)),
        current_(small_.get()),
        // Twice what the explicit method takes on the frame, 8 a part at 1e-5 to 53 at 1e-11.
        explicit_evaluations_(std::lround(16 * std::pow(1e-5 / relative_tolerance, 0.14))) {}

  Status advance(const Drive& drive, double duration) noexcept override {
    if (current_ == large_.get()) return large_->advance(drive, duration);
    if (n_costly_ >= most_costly) {
      large_->start_from(small_->state(), small_->positions());
      current_ = large_.get();
      return large_->advance(drive, duration);
    }
    const long before = small_->evaluations();
    const Status status = small_->advance(drive, duration);
    const bool costly = small_->evaluations() - before > explicit_evaluations_;
    n_costly_ = std::max(n_costly_ + (costly ? 1 : -1), 0);
    return status;
  }
  void velocities(Eigen::VectorXd& v) const noexcept override { current_->velocities(v); }
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override {
    current_->elastic_stresses(sigma);
  }
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override {
    current_->filtered_stresses(sigma);
  }
  long evaluations() const noexcept override {
    return small_->evaluations() + large_->evaluations();
  }
  std::string where() const override { return current_->where(); }
  /// Whether the explicit method goes on.
  bool is_large() const noexcept { return current_ == large_.get(); }

 private:
  /// A shock that is over soon is not worth leaving the exponential method for.
  static constexpr int most_costly = 50;

  std::unique_ptr<ExponentialMotion> small_;
  std::unique_ptr<OdeMotion> large_;
  Motion* current_;
  long explicit_evaluations_;
  int n_costly_ = 0;  ///< parts that were costly of late, less those that were not
};

}  // namespace stillframe

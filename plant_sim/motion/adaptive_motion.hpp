#pragma once

#include <memory>

#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// Of two methods the one that is cheaper at present, counted in evaluations of the equations: a
/// scene does not say beforehand how far it will swing, and when it will be quiet again. The one
/// for small motion goes on while it is as cheap as it can be. Where it is not, and now and then
/// while the other one goes on, the method that rests is given a few parts of the motion to show
/// what it costs there; each time that it costs more, it rests twice as long. Set-up: construction;
/// the rest is hot as Motion, but the change from one method to the other allocates.
class AdaptiveMotion final : public Motion {
 public:
  /// Both at the same operating point, on the same model, at the same tolerance. large_weight: time
  /// of an evaluation of `large` over that of one of `small`.
  AdaptiveMotion(std::unique_ptr<NonlinearMotion> small, std::unique_ptr<NonlinearMotion> large,
                 double large_weight, Eigen::Index size);

  Status advance(const Drive& drive, double duration) noexcept override;
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
  Eigen::VectorXd displacements() const override { return current_->displacements(); }
  /// Whether the method for large motion goes on.
  bool is_large() const noexcept { return current_ == large_.get(); }

 private:
  double weight() const noexcept { return is_large() ? large_weight_ : 1; }
  bool change(const Drive& drive) noexcept;
  /// After a part at such a cost, decides who makes the next one.
  void judge(double cost) noexcept;

  std::unique_ptr<NonlinearMotion> small_, large_;
  double large_weight_;
  NonlinearMotion* current_;
  MotionSnapshot snapshot_;
  bool change_next_ = false, on_trial_ = false;
  int parts_ = 0;    ///< since the last change, or since a cost was last looked at
  int wait_;         ///< parts until the other method has its next trial
  double cost_ = 0;  ///< of the present method, mean of late, in evaluations of `small` a part
  double cost_before_ = 0;  ///< of the other method when it was left
  double cost_tried_;       ///< of the method for small motion when the other one was last tried
};

}  // namespace stillframe

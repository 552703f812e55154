#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "controller/designed_loop.hpp"
#include "controller/gains.hpp"

namespace stillframe::controller {

/// Whether the frame has felt the floor that its sensors report. The PI feedback of the gains,
/// closed around the model of the frame, is asked twice which forces would hold the frame still:
/// f, under the floor w that is heard; d, of an observer that hears no floor, but the forces that
/// act and what the force sensors read, whose error is its floor. Frame and law are linear, so a
/// true floor makes f = d whatever else the loop does. Of leg i a floor is not believed that asks
/// for more than the legs say, |f_i| > |d_i|, by
///   |f_i - d_i| > D_i / 2 + min(6 e_i, 2 D_i),
/// D_i the largest |d_i|, forgotten within seconds, or a tenth of that of another leg if it is
/// more; e_i the root mean square of f_i - d_i so far, which noise and an error of the model make;
/// of 2 D_i no less than of what a floor of 0.1 mm/s^2 asks for.
/// What pushes the frame and is no floor makes d large, and nobody a liar. All that is heard passes
/// a high-pass at a tenth of the lowest target. Construction is set-up; the rest is hot: noexcept,
/// no allocation. Source: docs/safety.md.
class FloorEvidence {
 public:
  /// Knows nothing, and believes all, where gains hear no floor, or that feedback around their own
  /// plant is not stable. Errors: as DesignedLoop.
  explicit FloorEvidence(const Gains& gains);

  /// n samples after the last one: the floor (p, m/s^2), what the force sensors read and the forces
  /// that are said to act (m, N). Answers the acceleration of the floor that has grown most where
  /// they are not to be believed, or -1.
  Eigen::Index hear(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& w,
                    const Eigen::Ref<const Eigen::VectorXd>& sigma,
                    const Eigen::Ref<const Eigen::VectorXd>& applied) noexcept;

  /// Whether it has heard enough to tell; true for one that knows nothing.
  bool judges() const noexcept { return !heard_ || (n_ >= settled_ && 2 * n_learned_ >= settled_); }

  template <class Archive>
  void visit(Archive& archive) {
    if (!heard_) return;
    archive(n_), archive(sound_), archive(n_learned_), archive(slow_), archive(before_),
        archive(usual_), archive(largest_), archive(squares_);
    heard_->visit(archive);
    felt_->visit(archive);
  }

 private:
  Eigen::VectorXd asked_by_a_quiet_floor(double angle);
  void follow(std::int64_t n) noexcept;
  void begin(const Eigen::Ref<const Eigen::VectorXd>& all) noexcept;
  bool is_believed() noexcept;

  std::optional<DesignedLoop> heard_, felt_;
  Eigen::Index m_ = 0, p_ = 0;
  std::int64_t settled_ = 0, n_ = 0;    ///< samples
  std::int64_t sound_ = 0;              ///< samples since one was not believed
  std::int64_t n_learned_ = 0;          ///< samples that squares_ is a mean of
  double slow_kept_ = 0, kept_ = 0;     ///< parts of what is remembered after a sample
  double learns_ = 0;                   ///< part of a mean that a sample replaces
  Eigen::VectorXd now_, slow_, moves_;  ///< p + 2 m: w, sigma and applied
  Eigen::VectorXd before_;              ///< the same, what was followed last of moves_
  Eigen::VectorXd usual_;               ///< p, (m/s^2)^2, mean square of the floor
  Eigen::VectorXd largest_, squares_;   ///< m, N and N^2: D, e squared
  Eigen::VectorXd quiet_;               ///< m, N, f of a floor that is too quiet to be measured
  Eigen::VectorXd no_floor_, nothing_;  ///< p; m
  Eigen::VectorXd minus_sigma_;         ///< m, N
};

}  // namespace stillframe::controller

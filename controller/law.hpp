#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "controller/floor_filter.hpp"
#include "controller/gains.hpp"
#include "core/control/discrete_law.hpp"

namespace stillframe::controller {

/// The sampled control law of a set of gains: sample_law of core/control/discrete_law.hpp, or the
/// law that they bring (core/control/own_law.hpp). Set-up. Errors: Refusal if I + K_P is singular,
/// std::invalid_argument on gains that are not square or not of one size; as own_law.
DiscreteLaw law_from_gains(const Gains& gains);

/// The law as it runs, one step a sample:
///   r[k] = a r[k-1] + (1 - a) applied[k],   e[k] = sigma[k] - (subtract_applied ? r[k] : 0),
///   u[k] = C x[k] + D e[k] + s f[k],   x[k+1] = A x[k] + B e[k],
/// f the force of the feed-forward (floor_filter.hpp), s its share, 1 or less; e[k] = (sigma[k],
/// applied[k]) where the law hears the applied force by itself.
/// Source: core/control/discrete_law.hpp. Construction is set-up; step and reset are
/// hot: noexcept, no allocation.
class Law {
 public:
  static constexpr std::int64_t longest_gap = 100;

  /// Errors: std::invalid_argument on shapes that do not match.
  explicit Law(DiscreteLaw matrices);

  Eigen::Index n_legs() const noexcept { return matrices_.D.rows(); }

  /// One sample: sigma, applied and force are m forces in N; writes force and moves the state.
  void step(const Eigen::Ref<const Eigen::VectorXd>& sigma,
            const Eigen::Ref<const Eigen::VectorXd>& applied,
            Eigen::Ref<Eigen::VectorXd> force) noexcept;

  /// The same where n_samples samples have passed since the last step (1: none was missed): the law
  /// runs through all of them, with e interpolated linearly between its last value and the present
  /// one. Without that, a missed sample would stop the law's clock, and a lead would take the
  /// change over n samples for that over one. At most longest_gap samples are made up for.
  void step_over(std::int64_t n_samples, const Eigen::Ref<const Eigen::VectorXd>& sigma,
                 const Eigen::Ref<const Eigen::VectorXd>& applied,
                 Eigen::Ref<Eigen::VectorXd> force) noexcept;

  /// The floor (p, m/s^2) of the measurement that is answered next, n samples after the one before:
  /// heard before step, or without any step. share: of the feed-forward in the force, which goes
  /// within some samples while the floor is not believed. A floor of another size than the
  /// feed-forward has inputs is not heard.
  void hear_floor(std::int64_t n_samples, const Eigen::Ref<const Eigen::VectorXd>& floor,
                  double share = 1, bool believed = true) noexcept {
    floor_.hear(n_samples, floor, believed);
    share_ = share;
  }
  /// What the feed-forward of another law has heard, which is the same one.
  void hear_as(const Law& other) noexcept { floor_.hear_as(other.floor_); }
  const FloorFilter& floor() const noexcept { return floor_; }

  /// The feedback back to rest, x = 0, e = 0 and r = 0. The feed-forward, which has no loop, goes
  /// on.
  void reset() noexcept {
    x_.setZero();
    e_last_.setZero();
    r_.setZero();
  }

  /// What was heard of the floor is forgotten: it has been at rest.
  void rest_floor() noexcept { floor_.rest(); }

  /// n states of the law, N.
  const Eigen::VectorXd& state() const noexcept { return x_; }

  /// Hands all that a later force depends on to an archive.
  template <class Archive>
  void visit(Archive& archive) {
    archive(x_), archive(e_last_), archive(r_), archive(share_);
    floor_.visit(archive);
  }

 private:
  void advance() noexcept;

  DiscreteLaw matrices_;
  FloorFilter floor_;
  double share_ = 1;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> blocks_;  ///< of A, first row and rows
  Eigen::VectorXd x_, x_next_, e_, e_now_, e_last_, r_;
};

}  // namespace stillframe::controller

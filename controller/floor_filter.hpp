#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/systems/linear_system.hpp"

namespace stillframe::controller {

/// A feed-forward as it runs, one step a sample: u[k] = C x[k] + D w[k], x[k+1] = A x[k] + B w[k],
/// p accelerations of the floor in (m/s^2), m forces out (N). A and B are nearly empty, most of
/// their rows hand a sample on to the next state, and no more than that is computed. It has no loop
/// through the frame, so it hears the floor whether or not its force is commanded. Construction is
/// set-up; the rest is hot: noexcept, no allocation.
class FloorFilter {
 public:
  /// More samples than this without a floor, and it begins anew.
  static constexpr std::int64_t longest_gap = 100;

  /// system: without columns in D hears nothing, and its force is zero. m: forces. Errors:
  /// std::invalid_argument on shapes that do not match.
  FloorFilter(const LinearSystem& system, Eigen::Index m);

  Eigen::Index n_floor() const noexcept { return n_floor_; }

  /// The floor (p, m/s^2) n samples after the last one; of those between it is on the line from the
  /// last to this one, as the floor of a law that lost samples is nowhere else more likely. The
  /// first one is taken to have stood for ever: what a sensor is constantly off by is no motion.
  /// While they are not believed the force goes within some samples, and the next that is believed
  /// begins anew with their mean for what has stood for ever: of one reading the hum of a building
  /// would be left, for seconds.
  void hear(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& w,
            bool believed = true) noexcept;
  /// The force (m, N) that goes with the floor that was heard last.
  const Eigen::VectorXd& force() const noexcept { return force_; }

  /// It has heard what another of the same system has.
  void hear_as(const FloorFilter& other) noexcept;

  /// The floor has been at rest, and what comes next is its motion.
  void rest() noexcept;

  template <class Archive>
  void visit(Archive& archive) {
    archive(z_), archive(force_), archive(rest_), archive(n_rest_), archive(begun_);
  }

 private:
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// x[k+1] at to is z[k] at from, for so many states in a row.
  struct Move {
    Eigen::Index to, from, n;
  };
  /// Of the row `to` of (A B).
  struct Term {
    Eigen::Index to, from;
    double factor;
  };

  Eigen::Index n_states() const noexcept { return z_.size() - n_floor_; }
  void step() noexcept;

  Eigen::Index n_floor_;
  std::vector<Move> moves_;
  std::vector<Term> terms_;
  std::vector<Eigen::Index> summed_;  ///< rows that terms_ add up to
  RowMatrix outputs_;                 ///< m x (n + p), (C D)
  Eigen::MatrixXd at_rest_;           ///< n x p, (I - A)^-1 B: x of a floor that stands for ever
  Eigen::VectorXd z_, next_;          ///< n + p: x and the floor that was heard last
  Eigen::VectorXd last_, rest_, force_;
  double n_rest_ = 0;  ///< samples in the mean of those that are not believed
  bool begun_ = false;
};

}  // namespace stillframe::controller

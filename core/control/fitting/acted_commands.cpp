#include "core/control/fitting/acted_commands.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace stillframe::fitting {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Whole samples of delay and age of a report, a part of a sample, and what amplifiers lag.
constexpr Index n_weights = 16;
// Late ones in a row whose reports overlap.
constexpr Index at_once = 4;
// Standard deviations that two commands are apart in their reports, to be told from each other:
// half of them is beyond chance in any recording.
constexpr double told = 14;
constexpr double nothing = 1e-6;  // of a variance
// Late commands spoil the weights by which they are found, a little.
constexpr int most_passes = 5;

class Reports {
 public:
  Reports(const MatrixXd& command, const MatrixXd& applied, const std::vector<bool>& missing)
      : sent_(command), applied_(applied), missing_(missing) {}

  /// Of each leg, by least squares over all rows, and what they leave. False if nothing moves.
  /// acted: commands, as far as is known.
  bool weigh(const MatrixXd& acted) {
    weights_ = MatrixXd::Zero(n_weights, legs());
    rms_ = VectorXd::Zero(legs());
    off_ = MatrixXd::Zero(rows(), legs());
    bool any = false;
    for (Index leg = 0; leg < legs(); ++leg) {
      MatrixXd JtJ = MatrixXd::Zero(n_weights + 1, n_weights + 1);
      VectorXd Jtr = VectorXd::Zero(n_weights + 1), row(n_weights + 1);
      row(n_weights) = 1;  // an offset
      for (Index k = n_weights - 1; k < rows(); ++k) {
        if (is_missing(k)) continue;
        row.head(n_weights) = acted.col(leg).segment(k - n_weights + 1, n_weights).reverse();
        JtJ.selfadjointView<Eigen::Lower>().rankUpdate(row);
        Jtr += row * applied_(k, leg);
      }
      const double size = JtJ.diagonal().head(n_weights).maxCoeff();
      if (!(size > 0)) continue;
      any = true;
      // Lines may be too few for so many weights.
      JtJ.diagonal().head(n_weights).array() += 1e-9 * size;
      const VectorXd found = JtJ.selfadjointView<Eigen::Lower>().ldlt().solve(Jtr);
      weights_.col(leg) = found.head(n_weights);
      const auto off = [&](const MatrixXd& commands, Index k) {
        return applied_(k, leg) - found(n_weights) -
               found.head(n_weights).dot(
                   commands.col(leg).segment(k - n_weights + 1, n_weights).reverse());
      };
      std::vector<double> sizes;
      for (Index k = n_weights - 1; k < rows(); ++k) {
        if (is_missing(k)) continue;
        off_(k, leg) = off(sent_, k);
        sizes.push_back(std::abs(off(acted, k)));
      }
      // The middle one, which a few that are late do not move.
      const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
      std::ranges::nth_element(sizes, middle);
      rms_(leg) = std::max(1.5 * *middle, 1e-9 * std::sqrt(size / static_cast<double>(rows())));
    }
    return any;
  }

  /// In the order of time: whether one is late hangs on whether the one before was.
  Index put_right(MatrixXd& acted) {
    Index n_late = 0;
    acted = sent_;
    for (Index k = 1; k + n_weights + at_once < rows(); ++k) {
      if (!is_late(acted, k)) continue;
      move(k, acted.row(k - 1) - acted.row(k));
      acted.row(k) = acted.row(k - 1);
      ++n_late;
    }
    return n_late;
  }

 private:
  Index rows() const { return sent_.rows(); }
  Index legs() const { return sent_.cols(); }
  bool is_missing(Index k) const {
    return !missing_.empty() && missing_[static_cast<std::size_t>(k)];
  }

  /// Takes what acts more at row k out of what reports are off by.
  void move(Index k, const Eigen::RowVectorXd& change) {
    for (Index j = 0; j < n_weights; ++j) {
      if (is_missing(k + j)) continue;
      off_.row(k + j) -= weights_.row(j).cwiseProduct(change);
    }
  }

  /// What acted at row k is nearer to the command before than to its own, as far as reports tell
  /// them apart.
  bool is_late(const MatrixXd& acted, Index k) const {
    double along = 0, size = 0;
    for (Index leg = 0; leg < legs(); ++leg) {
      const double change = acted(k - 1, leg) - acted(k, leg);
      if (rms_(leg) == 0 || change == 0) continue;
      const auto [moved, variance] = moved_at(leg, k);
      along += moved * change / variance;
      size += change * change / variance;
    }
    return size > told * told && along > 0.5 * size && along < 1.5 * size;
  }

  /// By how much what acted on a leg at row k is off, N, and the variance of that: of it and the
  /// next few by least squares, up to where the last of them has been reported.
  std::pair<double, double> moved_at(Index leg, Index k) const {
    const VectorXd w = weights_.col(leg) / rms_(leg);
    const auto main = std::ranges::find_if(
        w, [&](double weight) { return std::abs(weight) > 0.5 * w.cwiseAbs().maxCoeff(); });
    const Index n = (main - w.begin()) + at_once;
    MatrixXd J = MatrixXd::Zero(n, at_once);
    VectorXd r = VectorXd::Zero(n);
    for (Index i = 0; i < n; ++i) {
      if (is_missing(k + i)) continue;
      r(i) = off_(k + i, leg) / rms_(leg);
      for (Index of = 0; of < at_once; ++of) {
        if (i - of >= 0 && i - of < n_weights) J(i, of) = w(i - of);
      }
    }
    // Where reports did not come nothing is told.
    const MatrixXd covariance =
        (J.transpose() * J + nothing * w.squaredNorm() * MatrixXd::Identity(at_once, at_once))
            .inverse();
    return {covariance.row(0) * J.transpose() * r, covariance(0, 0)};
  }

  const MatrixXd &sent_, &applied_;
  const std::vector<bool>& missing_;
  MatrixXd weights_;  ///< n_weights x m
  VectorXd rms_;      ///< m, N; 0: does not move
  MatrixXd off_;      ///< n x m, N, what is reported less what acted would be reported as
};

}  // namespace

ActedCommands acted_commands(const MatrixXd& command, const MatrixXd& applied,
                             const std::vector<bool>& missing) {
  ActedCommands found{.command = command};
  if (command.rows() < 2 * (n_weights + at_once)) return found;
  Reports reports(command, applied, missing);
  for (int pass = 0; pass < most_passes && reports.weigh(found.command); ++pass) {
    const MatrixXd before = found.command;
    found.n_late = reports.put_right(found.command);
    if (found.command == before) break;
  }
  return found;
}

}  // namespace stillframe::fitting

#include "core/control/fitting/acted_commands.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numerics/infinity.hpp"

namespace stillframe::fitting {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

namespace {

// A part of a sample of delay, and what amplifiers lag; from the first sample on that a report is
// looked for at, whole delays and ages.
constexpr Index n_weights = 16, first_step = 4, last_first = 40;
// Late ones in a row whose reports overlap.
constexpr Index at_once = 4;
// Standard deviations that two commands are apart in their reports, to be told from each other:
// half of them is beyond chance in any recording.
constexpr double told = 14;
constexpr double nothing = 1e-6;  // of a variance
// That a late one leaves at most of the power of what reports were off by before.
constexpr double most_left = 0.25;
// Late commands spoil the weights by which they are found, a little.
constexpr int most_passes = 5;

/// The way from the commands of a leg to its reports.
struct Way {
  Index first = 0;   ///< samples
  VectorXd weights;  ///< of the commands so many samples ago and of those before; empty: unknown
  double offset = 0;
  double rms = 0;  ///< N, what they leave, while commands change

  Index reach() const { return first + n_weights; }
  double of(const MatrixXd& commands, Index leg, Index k) const {
    return offset + weights.dot(commands.col(leg).segment(k - reach() + 1, n_weights).reverse());
  }
};

class Reports {
 public:
  Reports(const MatrixXd& command, const MatrixXd& applied, const std::vector<bool>& missing)
      : sent_(command), applied_(applied), missing_(missing) {
    ways_.resize(static_cast<std::size_t>(legs()));
  }

  /// By least squares over the rows at which commands change. False if nothing moves. acted:
  /// commands, as far as is known.
  bool weigh(const MatrixXd& acted) {
    off_ = MatrixXd::Zero(rows(), legs());
    bool any = false;
    for (Index leg = 0; leg < legs(); ++leg) {
      Way& way = ways_[static_cast<std::size_t>(leg)];
      const bool is_first = way.weights.size() == 0;
      if (!applied_.col(leg).allFinite()) continue;
      if (is_first) {
        double least = infinity;
        for (Index first = 0; first <= last_first; first += first_step) {
          const Way there = weighed(acted, leg, first);
          if (there.weights.size() == 0 || !(there.rms < least)) continue;
          least = there.rms;
          way = there;
        }
      } else {
        way = weighed(acted, leg, way.first);
      }
      if (way.weights.size() == 0) continue;
      any = true;
      for (Index k = way.reach() - 1; k < rows(); ++k) {
        if (!is_missing(k)) off_(k, leg) = applied_(k, leg) - way.of(sent_, leg, k);
      }
    }
    return any;
  }

  /// In the order of time: whether one is late hangs on whether the one before was.
  Index put_right(MatrixXd& acted) {
    acted = sent_;
    std::vector<Index> late;
    const Index last = rows() - (last_first + n_weights + at_once);
    for (Index k = 1; k < last; ++k) {
      const RowVectorXd instead = acts_instead(acted, k);
      if (instead.size() == 0) continue;
      move(k, instead - acted.row(k));
      acted.row(k) = instead;
      late.push_back(k);
    }
    return keep_sound(late, acted);
  }

 private:
  Index rows() const { return sent_.rows(); }
  Index legs() const { return sent_.cols(); }
  bool is_missing(Index k) const {
    return !missing_.empty() && missing_[static_cast<std::size_t>(k)];
  }

  Way weighed(const MatrixXd& acted, Index leg, Index first) const {
    Way way;
    way.first = first;
    MatrixXd JtJ = MatrixXd::Zero(n_weights + 1, n_weights + 1);
    VectorXd Jtr = VectorXd::Zero(n_weights + 1), row(n_weights + 1);
    row(n_weights) = 1;  // an offset
    std::vector<Index> driven;
    for (Index k = way.reach() - 1; k < rows(); ++k) {
      if (is_missing(k)) continue;
      row.head(n_weights) = acted.col(leg).segment(k - way.reach() + 1, n_weights).reverse();
      if (row(0) == row(1)) continue;  // at rest, or held
      JtJ.selfadjointView<Eigen::Lower>().rankUpdate(row);
      Jtr += row * applied_(k, leg);
      driven.push_back(k);
    }
    const double size = JtJ.diagonal().head(n_weights).maxCoeff();
    if (!(size > 0) || driven.empty()) return way;
    // Lines may be too few for so many weights.
    JtJ.diagonal().head(n_weights).array() += 1e-9 * size;
    const VectorXd found = JtJ.selfadjointView<Eigen::Lower>().ldlt().solve(Jtr);
    if (!found.allFinite() || found.head(n_weights).norm() == 0) return way;
    way.weights = found.head(n_weights);
    way.offset = found(n_weights);
    std::vector<double> sizes;
    for (const Index k : driven) {
      sizes.push_back(std::abs(applied_(k, leg) - way.of(acted, leg, k)));
    }
    // The middle one, which a few that are late do not move.
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::ranges::nth_element(sizes, middle);
    way.rms = std::max(1.5 * *middle, 1e-9 * std::sqrt(size / static_cast<double>(rows())));
    return way;
  }

  /// Takes what acts more at row k out of what reports are off by.
  void move(Index k, const RowVectorXd& change) {
    for (Index leg = 0; leg < legs(); ++leg) {
      const Way& way = ways_[static_cast<std::size_t>(leg)];
      for (Index j = 0; j < way.weights.size(); ++j) {
        const Index at = k + way.first + j;
        if (!is_missing(at)) off_(at, leg) -= way.weights(j) * change(leg);
      }
    }
  }

  /// What acted at row k rather than its own command, if reports tell that: the one that acted
  /// before, or the one that was sent before, which then came late itself. Empty: its own.
  RowVectorXd acts_instead(const MatrixXd& acted, Index k) const {
    const RowVectorXd own = acted.row(k);
    const RowVectorXd others[] = {acted.row(k - 1), sent_.row(k - 1)};
    if (own == others[0] && own == others[1]) return {};
    VectorXd moved = VectorXd::Zero(legs()), weight = moved;
    for (Index leg = 0; leg < legs(); ++leg) {
      if (ways_[static_cast<std::size_t>(leg)].weights.size() == 0) continue;
      const auto [value, variance] = moved_at(leg, k);
      moved(leg) = value;
      weight(leg) = 1 / variance;
    }
    const auto power = [&](const VectorXd& change) { return change.cwiseAbs2().dot(weight); };
    RowVectorXd best;
    double least = power(moved);
    for (const RowVectorXd& other : others) {
      const VectorXd change = (other - own).transpose();
      const double apart = power(change), left = power(moved - change);
      if (apart > told * told && left < least && left < 0.25 * apart) {
        least = left;
        best = other;
      }
    }
    return best;
  }

  /// By how much what acted on a leg at row k is off, N, and the variance of that: of it and the
  /// next few by least squares, up to where the last of them has been reported.
  std::pair<double, double> moved_at(Index leg, Index k) const {
    const Way& way = ways_[static_cast<std::size_t>(leg)];
    const VectorXd w = way.weights / way.rms;
    const double largest = w.cwiseAbs().maxCoeff();
    const auto main =
        std::ranges::find_if(w, [&](double weight) { return std::abs(weight) > 0.5 * largest; });
    const Index n = (main - w.begin()) + at_once;
    MatrixXd J = MatrixXd::Zero(n, at_once);
    VectorXd r = VectorXd::Zero(n);
    for (Index i = 0; i < n; ++i) {
      const Index at = k + way.first + i;
      if (is_missing(at)) continue;
      r(i) = off_(at, leg) / way.rms;
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

  /// An amplifier that its weights cannot say is off everywhere, and seems to have late commands:
  /// one is kept where without it reports are off by far more. How many are.
  Index keep_sound(const std::vector<Index>& late, MatrixXd& acted) {
    Index kept = 0;
    for (const Index k : late) {
      const RowVectorXd back = sent_.row(k) - acted.row(k);
      double with = 0, without = 0;
      for (Index leg = 0; leg < legs(); ++leg) {
        const Way& way = ways_[static_cast<std::size_t>(leg)];
        if (way.weights.size() == 0) continue;
        for (Index j = 0; j < n_weights; ++j) {
          const Index at = k + way.first + j;
          if (is_missing(at)) continue;
          const double now = off_(at, leg) / way.rms,
                       then = now - way.weights(j) * back(leg) / way.rms;
          with += now * now;
          without += then * then;
        }
      }
      if (with < most_left * without) {
        ++kept;
        continue;
      }
      move(k, back);
      acted.row(k) = sent_.row(k);
    }
    return kept;
  }

  const MatrixXd &sent_, &applied_;
  const std::vector<bool>& missing_;
  std::vector<Way> ways_;  ///< of each leg
  MatrixXd off_;           ///< n x m, N, what is reported less what acted would be reported as
};

}  // namespace

ActedCommands acted_commands(const MatrixXd& command, const MatrixXd& applied,
                             const std::vector<bool>& missing) {
  ActedCommands found{.command = command};
  if (command.rows() < 2 * (last_first + n_weights + at_once)) return found;
  Reports reports(command, applied, missing);
  for (int pass = 0; pass < most_passes && reports.weigh(found.command); ++pass) {
    const MatrixXd before = found.command;
    found.n_late = reports.put_right(found.command);
    if (found.command == before) break;
  }
  return found;
}

}  // namespace stillframe::fitting

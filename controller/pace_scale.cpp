#include "controller/pace_scale.hpp"

#include <algorithm>
#include <cmath>

#include "controller/designed_loop.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// Standard deviations: six are met once in days by one leg at 1 kHz, and calibrations, masses and
// stiffnesses, by which more noise may come back, are not those of the model. What the floor may
// ask for needs no such margin: real floors ask for a quarter of it.
constexpr double sure = 9;
// By how much of what any floor may ask for a sound loop differs from the designed one: as no floor
// that was met asks for more, a frame with other masses, stiffnesses, calibrations and clocks than
// the model's stays within it.
constexpr double not_as_designed = 0.25;
// Nor by more than this many times of what the designed loop has done of late: one that swings as
// much in another phase differs by twice that.
constexpr double of_its_own = 2;

/// The smallest memory with which 2 max |h| memory^k is at least |h[k]| for every sample k and leg.
double memory_of(const MatrixXd& h) {
  double memory = 0;
  for (Index i = 0; i < h.rows(); ++i) {
    const double peak = h.row(i).cwiseAbs().maxCoeff();
    if (!(peak > 0)) continue;
    for (Index k = 1; k < h.cols(); ++k) {
      memory =
          std::max(memory, std::pow(std::abs(h(i, k)) / (2 * peak), 1 / static_cast<double>(k)));
    }
  }
  return memory;
}

double power(double base, std::int64_t n) noexcept {
  return n == 1 ? base : std::pow(base, static_cast<double>(n));
}

}  // namespace

PaceScale::PaceScale(Index m, Index p, double keep)
    : keep_(keep),
      free_(VectorXd::Zero(m)),
      per_floor_(MatrixXd::Zero(m, p)),
      per_noise_(MatrixXd::Zero(m, m)),
      per_offset_(MatrixXd::Zero(m, m)),
      per_held_(MatrixXd::Zero(m, m)),
      per_excited_(MatrixXd::Zero(m, m)),
      per_lost_(MatrixXd::Zero(m, p)) {
  reading_ = swing_ = doubt_ = held_ = excited_ = noise_ = designed_ = met_ = lost_ = caught_up_ =
      force_ = VectorXd::Zero(m);
}

MatrixXd PaceScale::remembered(MatrixXd z) const {
  for (Index k = 1; k < z.cols(); ++k) z.col(k) += keep_ * z.col(k - 1);
  return z;
}

void PaceScale::learn(const Ref<const MatrixXd>& changes, Index j) {
  const MatrixXd z = remembered(changes);
  const Index p = per_floor_.cols();
  if (j < p) {
    per_floor_.col(j) = z.cwiseAbs().rowwise().sum();
    per_lost_.col(j) = 2 * z.cwiseAbs().rowwise().maxCoeff();
    keep_lost_ = std::max(keep_lost_, memory_of(z));
    return;
  }
  per_noise_.col(j - p) = z.cwiseAbs2().rowwise().sum();
}

void PaceScale::learn_excitation(const Ref<const MatrixXd>& changes, Index j) {
  per_excited_.col(j) = remembered(changes).cwiseAbs().rowwise().sum();
}

void PaceScale::learn_offset(const Ref<const MatrixXd>& changes, Index k) {
  per_offset_.col(k) = remembered(changes).cwiseAbs().rowwise().maxCoeff();
}

void PaceScale::learn_letting_go(const Ref<const MatrixXd>& changes, Index k, double held,
                                 double kept) {
  MatrixXd z = remembered(changes);
  // So that what is forgotten on the way is there as long as it is needed.
  for (Index n = 0; n < z.cols(); ++n) z.col(n) /= std::pow(kept, static_cast<double>(n));
  if (std::abs(held) > 0) per_held_.col(k) = z.cwiseAbs().rowwise().maxCoeff() / std::abs(held);
}

void PaceScale::let_go(const Ref<const VectorXd>& force) noexcept {
  for (Index i = 0; i < held_.size(); ++i) {
    held_(i) = std::max(held_(i), per_held_.row(i).dot(force.cwiseAbs()));
  }
}

void PaceScale::excite(const Ref<const VectorXd>& force) noexcept {
  for (Index i = 0; i < excited_.size(); ++i) {
    excited_(i) = std::max(excited_(i), per_excited_.row(i).dot(force.cwiseAbs()));
  }
}

void PaceScale::restart() noexcept {
  swing_.setZero();
  reading_.setZero();
}

void PaceScale::listen(const Ref<const VectorXd>& change, bool first) noexcept {
  if (first) {
    reading_.setZero();
    return;
  }
  reading_ = keep_ * reading_ + change;
  swing_ = swing_.cwiseMax(reading_.cwiseAbs());
}

void PaceScale::begin(const Ref<const VectorXd>& doubt,
                      const Ref<const VectorXd>& variance) noexcept {
  doubt_.noalias() = per_offset_ * doubt;
  noise_.noalias() = per_noise_ * variance;
  noise_ = sure * noise_.cwiseSqrt();
  held_.setZero();
  excited_.setZero();
  designed_.setZero();
  met_.setZero();
  lost_.setZero();
  caught_up_.setZero();
  force_.setZero();
}

void PaceScale::forget(double kept, std::int64_t n, bool whole, bool floor_known) noexcept {
  doubt_ *= kept;
  held_ *= kept;
  excited_ *= kept;
  met_ *= kept;
  if (floor_known) swing_ *= whole ? std::min(kept, power(keep_lost_, n)) : kept;
}

void PaceScale::expect(std::int64_t n, const Ref<const VectorXd>& change) noexcept {
  designed_ = power(keep_, n) * designed_ + change;
  met_ = met_.cwiseMax(designed_.cwiseAbs());
  const double kept = power(keep_lost_, n);
  lost_ *= kept;
  caught_up_ *= kept;
  if (n > DesignedLoop::longest_step) caught_up_ = caught_up_.cwiseMax(designed_.cwiseAbs());
}

void PaceScale::doubt_floor(const Ref<const VectorXd>& w) noexcept {
  lost_.noalias() += per_lost_ * w;
}

void PaceScale::lose_track(const Ref<const VectorXd>& largest) noexcept {
  lost_.noalias() = per_floor_ * largest;
}

double PaceScale::most(Index i, const VectorXd* largest, double n) const noexcept {
  const double beside = noise_(i) + doubt_(i) + held_(i) + excited_(i) + free_(i);
  if (largest == nullptr) return n * (beside + 4 * swing_(i));
  const double any_floor = per_floor_.row(i).dot(*largest), designed = std::abs(designed_(i));
  const double other = not_as_designed * any_floor;
  return n * (beside + 2 * swing_(i)) +
         std::min(std::max(n * any_floor + caught_up_(i), designed + n * other),
                  designed + n * (std::min(other, of_its_own * met_(i)) + lost_(i)));
}

void PaceScale::command(std::int64_t n, const Ref<const VectorXd>& change) noexcept {
  force_ = power(keep_, n) * force_ + change;
}

}  // namespace stillframe::controller

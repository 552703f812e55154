#include "controller/floor_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "controller/slow_loops.hpp"
#include "core/control/close_loop.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// Of the corner below which a floor is not followed: with the leak of a law that holds a frame
// still, a beginning would be remembered for a minute. The target is at ten.
constexpr double leaks = 4, above_corner = 10;
// In which a difference of the models has died out that began with what they heard first.
constexpr double settles_s = 1.5;
constexpr double forgets_s = 3;  // as the pace forgets how large a floor was
// The noise of sensors that are integrated to the force of a floor takes seconds to swing.
constexpr double learns_s = 10;
// Actuators that are off by 5 %, springs by 10 and sensors that are tilted leave a third.
constexpr double part_of_felt = 0.5, roots = 6, part_of_another = 0.1;
// What lies from the first sample on, or more and more, is no noise.
constexpr double most_usual = 2;
// m/s^2: what a floor asks for that is too quiet to be measured may be noise, too.
constexpr double quiet_floor = 1e-4;

/// The feedback of the gains by itself, whose forces act and are heard at once and as they are:
/// what lags between a command and its force is in the force that is reported.
Gains observing(Gains gains) {
  gains.forget_floor();
  gains.law.reset();
  gains.leak_hz = std::max(gains.leak_hz, leaks * floor_corner(gains) / two_pi);
  gains.instruments.actuator_gain = 1;
  gains.instruments.actuator_lag_hz = 0;
  gains.instruments.report = Instruments::Report::measured;
  gains.instruments.report_age_samples = 0;
  return gains;
}

bool is_stable(const Gains& gains) {
  const SampledPlant plant = sample_and_hold(gains.feedback_plant(), gains.sampling());
  const SampledLoop loop = close_loop(plant, law_from_gains(gains));
  return loop.A.allFinite() && spectral_radius(loop.A) < 1;
}

}  // namespace

FloorEvidence::FloorEvidence(const Gains& gains) {
  if (gains.heard_floor().empty()) return;
  const Gains observer = observing(gains);
  if (!is_stable(observer)) return;
  heard_.emplace(observer);
  felt_.emplace(observer);
  m_ = gains.n_legs();
  p_ = heard_->n_floor();
  slow_kept_ = std::exp(-floor_corner(gains) * gains.sample_time());
  kept_ = std::exp(-gains.sample_time() / slowed(forgets_s, gains.sample_rate_hz));
  learns_ = gains.sample_time() / slowed(learns_s, gains.sample_rate_hz);
  settled_ = std::llround(slowed(settles_s, gains.sample_rate_hz) / gains.sample_time());
  now_ = slow_ = moves_ = before_ = VectorXd::Zero(p_ + 2 * m_);
  usual_ = no_floor_ = VectorXd::Zero(p_);
  largest_ = squares_ = nothing_ = minus_sigma_ = VectorXd::Zero(m_);
  quiet_ = asked_by_a_quiet_floor(above_corner * floor_corner(gains) * gains.sample_time());
}

// Of a floor that swings as one by `angle` a sample, once that has settled.
VectorXd FloorEvidence::asked_by_a_quiet_floor(double angle) {
  VectorXd most = VectorXd::Zero(m_), w(p_);
  for (std::int64_t k = 0; k < 2 * settled_; ++k) {
    w.setConstant(quiet_floor * std::sin(angle * static_cast<double>(k)));
    heard_->step(1, w, nothing_, 1);
    if (k > settled_) most = most.cwiseMax(heard_->command().cwiseAbs());
  }
  return most;
}

void FloorEvidence::begin(const Ref<const VectorXd>& all) noexcept {
  heard_->reset(1);
  felt_->reset(1);
  slow_ = all;
  before_.setZero();
  n_ = 0;
}

bool FloorEvidence::is_believed() noexcept {
  const double another = part_of_another * largest_.maxCoeff();
  for (Index i = 0; i < m_; ++i) {
    const double f = heard_->command()(i), d = -felt_->command()(i);
    const double root = std::sqrt(squares_(i));
    const double felt = std::max(largest_(i), another);
    const double usual = std::min(roots * root, most_usual * std::max(felt, quiet_(i)));
    const double most = part_of_felt * felt + usual;
    if (std::abs(f) > std::abs(d) && std::abs(f - d) > most) return false;
  }
  return true;
}

void FloorEvidence::follow(std::int64_t n) noexcept {
  heard_->step(n, before_.head(p_), nothing_, 1);
  felt_->act_beside(before_.tail(m_));
  minus_sigma_ = -before_.segment(p_, m_);
  felt_->step(n, no_floor_, minus_sigma_, 1);
}

Index FloorEvidence::hear(std::int64_t n, const Ref<const VectorXd>& w,
                          const Ref<const VectorXd>& sigma,
                          const Ref<const VectorXd>& applied) noexcept {
  if (!heard_ || w.size() != p_) return -1;
  now_ << w, sigma, applied;
  if (n_ == 0 || n > FloorFilter::longest_gap) begin(now_);
  const auto samples = static_cast<double>(n);
  const double slow_kept = n == 1 ? slow_kept_ : std::pow(slow_kept_, samples);
  const double kept = n == 1 ? kept_ : std::pow(kept_, samples);
  slow_ = slow_kept * slow_ + (1 - slow_kept) * now_;
  moves_ = now_ - slow_;
  // What was lost lies on the line to what came, in steps that the loops can follow.
  for (std::int64_t left = n; left > 0; left -= DesignedLoop::longest_step) {
    const double part =
        static_cast<double>(std::min(left, DesignedLoop::longest_step)) / static_cast<double>(left);
    before_ += part * (moves_ - before_);
    follow(std::min(left, DesignedLoop::longest_step));
  }
  n_ += n;
  if (n_ < settled_) {
    sound_ = n_;
    return -1;
  }
  largest_ = (kept * largest_).cwiseMax(felt_->command().cwiseAbs());
  const bool believed = !judges() || is_believed();
  Index grown = -1;
  if (!believed) (moves_.head(p_).array().square() / (usual_.array() + 1e-300)).maxCoeff(&grown);
  sound_ = believed ? sound_ + n : 0;
  if (!believed) return grown;
  // A lie that swings is no usual difference. At first the mean of all there were.
  if (sound_ < settled_) return -1;
  n_learned_ += n;
  const double part = std::max(learns_, samples / static_cast<double>(n_learned_));
  usual_ += part * (moves_.head(p_).cwiseAbs2() - usual_);
  squares_ += part * ((heard_->command() + felt_->command()).cwiseAbs2() - squares_);
  return -1;
}

}  // namespace stillframe::controller

#pragma once

#include <cmath>
#include <functional>
#include <random>

#include "controller/in_process_io.hpp"
#include "controller/loop.hpp"
#include "core/linear/smooth_step.hpp"
#include "core/worst.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller::toy {

/// The toy frame on a shaking floor and the loop, in one thread, on a clock of its own: sample k is
/// taken at k T, the loop wakes at (k + 1/2) T unless it is told otherwise, and what it commands
/// acts from (k + 1) T on, until the amplifiers miss it. The frame has unit masses, so its
/// acceleration is -sigma.
class Rig {
 public:
  explicit Rig(const Policy& policy = {}, bool active = true, const Gains& gains = toy::gains(5))
      : period_ns(std::llround(1e9 / gains.sample_rate_hz)),
        gains_(gains),
        io_(gains.n_legs()),
        supervisor_(law_from_gains(gains), policy, gains.sample_rate_hz, gains.force_limit_n,
                    active),
        loop_(io_, supervisor_, policy, {.sample_rate_hz = gains.sample_rate_hz}),
        q_(Eigen::VectorXd::Zero(gains.n_legs())),
        v_(q_),
        force_(q_) {
    command_.force = q_;
    measurement_.sigma = measurement_.applied = q_;
  }

  /// What happens between the sensors and the loop in a sample; false: nothing arrives.
  using Wire = std::function<bool(Measurement&)>;

  /// One sample. awake: the loop is woken in it.
  void step(const Wire& wire = {}, bool awake = true) {
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      const double w = two_pi * frequencies_hz()[static_cast<size_t>(i)];
      measurement_.sigma(i) = w * w * q_(i) + force_(i);
    }
    peak = worst_of(peak, measurement_.sigma.cwiseAbs().maxCoeff());
    measurement_.seq = k_;
    measurement_.time_ns = k_ * period_ns;
    measurement_.applied = force_;
    measurement_.received_ns = k_ * period_ns + 1000;
    Measurement sent = measurement_;
    if (!wire || wire(sent)) io_.put(sent);
    sent_any = false;
    ++unheard_;
    if (awake) loop_.period(k_ * period_ns + period_ns / 2 + period_ns / 50);
    while (io_.take(command_)) {
      sent_any = true;
      unheard_ = 0;
      force_ = command_.force;
      largest_jump = worst_of(largest_jump, (force_ - force_before_).cwiseAbs().maxCoeff());
      force_before_ = force_;
    }
    const double T = gains_.sample_time();
    // The amplifiers hold a force for ten samples, and let it go within a second.
    if (unheard_ > 10) {
      force_ = (1 - smooth_step(static_cast<double>(unheard_ - 10) * T)) * force_before_;
    }
    // Noise through a low-pass of 10 Hz: a floor has little at high frequencies.
    floor_ += 0.06 * (normal_(random_) - floor_);
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      v_(i) -= floor_ * T;
      v_(i) *= damping;
      toy::move(static_cast<size_t>(i), q_(i), v_(i), force_(i), T);
    }
    ++k_;
  }
  void steps(int n, const Wire& wire = {}, bool awake = true) {
    for (int i = 0; i < n; ++i) step(wire, awake);
  }
  /// Goes on until a state is reached; false if it is not within so many samples.
  bool reaches(State state, int within, const Wire& wire = {}) {
    for (int i = 0; i < within; ++i) {
      if (loop_.counters().state == state) return true;
      step(wire);
    }
    return loop_.counters().state == state;
  }

  State state() const { return loop_.counters().state; }
  Fault fault() const { return loop_.counters().fault; }
  bool latched() const { return loop_.counters().latched; }
  const Eigen::VectorXd& force() const { return force_; }
  Loop& loop() { return loop_; }
  const Supervisor& supervisor() const { return supervisor_; }
  std::int64_t k() const { return k_; }

  const std::int64_t period_ns;
  double damping = 1 - 1.8e-3;  ///< of the velocity, a sample: about 2 % at 13.9 Hz
  double peak = 0;              ///< of sigma, and so of the frame's acceleration
  double largest_jump = 0;      ///< of the force between two commands
  bool sent_any = false;        ///< in the last sample

 private:
  Gains gains_;
  InProcessIo io_;
  Supervisor supervisor_;
  Loop loop_;
  Measurement measurement_;
  Command command_;
  Eigen::VectorXd q_, v_, force_, force_before_ = Eigen::VectorXd::Zero(4);
  double floor_ = 0;
  std::int64_t k_ = 0, unheard_ = 0;
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

/// The peak of the same frame left alone for so many samples.
inline double passive_peak(int n_samples) {
  Rig rig({}, false);
  rig.steps(n_samples);
  return rig.peak;
}

inline bool nothing(Measurement&) { return false; }

}  // namespace stillframe::controller::toy

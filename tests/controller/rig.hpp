#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "controller/in_process_io.hpp"
#include "controller/loop.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/worst.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {

/// Any designed loop and its frame in one thread, on a clock of its own: the exactly sampled plant
/// of a gains file with its instruments and its delay, shaken by a floor; sample k is taken at k T,
/// the loop wakes in it, and what it commands takes effect delay_samples later, until the
/// amplifiers miss it. Without wires it is the loop that the gains were designed as.
class Rig {
 public:
  /// What happens between the sensors and the loop in a sample; false: nothing arrives.
  using Wire = std::function<bool(Measurement&)>;
  /// What the actuators make of a force before it acts, m, N; the report follows it.
  using Actuators = std::function<void(Eigen::VectorXd&)>;
  /// The floor's acceleration over sample k (p, m/s^2).
  using Floor = std::function<void(std::int64_t, Eigen::VectorXd&)>;

  explicit Rig(const Policy& policy = {}, bool active = true,
               const Gains& gains = toy::damped_gains())
      : Rig(policy, active, gains, gains) {}

  /// The frame is that of other gains than the loop's: what a model does not know.
  Rig(const Policy& policy, bool active, const Gains& gains, const Gains& frame)
      : period_ns(std::llround(1e9 / gains.sample_rate_hz)),
        gains_(gains),
        plant_(sample_and_hold(frame.loop_plant(), frame.sampling())),
        io_(gains.n_legs(), 64, plant_.Gamma_w.cols()),
        supervisor_(gains, policy, active),
        loop_(io_, supervisor_, policy,
              {.sample_rate_hz = gains.sample_rate_hz, .n_floor = plant_.Gamma_w.cols()}) {
    const Eigen::Index m = gains.n_legs();
    x_ = Eigen::VectorXd::Zero(plant_.Phi.rows());
    force_ = before_ = sigma = Eigen::VectorXd::Zero(m);
    y = Eigen::VectorXd::Zero(plant_.C_y.rows());
    w_ = Eigen::VectorXd::Zero(plant_.Gamma_w.cols());
    command_.force = force_before_ = force_;
    measurement_.sigma = measurement_.applied = force_;
    measurement_.floor = w_;
    on_its_way_.assign(static_cast<std::size_t>(plant_.whole_delay(0)) + 1, force_);
    reports_.assign(static_cast<std::size_t>(plant_.report_age) + 1, force_);
    floor = [this](std::int64_t, Eigen::VectorXd& w) { shake(w); };
  }

  /// One sample. awake: the loop is woken in it.
  void step(const Wire& wire = {}, bool awake = true) {
    sigma.noalias() = plant_.C_sigma * x_ + plant_.D_sigma * before_;
    reports_.push_back(plant_.C_report * x_ + plant_.D_report * before_);
    reports_.pop_front();
    peak = worst_of(peak, worst_of(sigma));
    if (y.size() > 0) peak_y = worst_of(peak_y, worst_of(y));
    measurement_.seq = k_;
    measurement_.time_ns = std::llround(static_cast<double>(k_) * 1e9 / gains_.sample_rate_hz);
    measurement_.sigma = sigma;
    measurement_.applied = reports_.front();
    measurement_.floor = w_;
    measurement_.received_ns = measurement_.time_ns + 1000;
    measurement_.heard = unheard_ <= hold;
    Measurement sent = measurement_;
    if (!wire || wire(sent)) io_.put(sent);
    sent_any = false;
    ++unheard_;
    // Late by anything between nothing and a tenth of a period.
    const auto late = static_cast<std::int64_t>(late_(random_) * static_cast<double>(period_ns));
    if (awake) loop_.period(measurement_.time_ns + period_ns / 2 + late);
    while (io_.take(command_)) {
      sent_any = true;
      if (deaf) continue;
      unheard_ = 0;
      force_ = command_.force;
      largest_force = worst_of(largest_force, worst_of(force_));
      largest_jump = worst_of(largest_jump, worst_of(force_ - force_before_));
      force_before_ = force_;
    }
    // The amplifiers hold a force, and let it go within a second.
    if (unheard_ > hold) {
      const double missed_s = static_cast<double>(unheard_ - hold) * gains_.sample_time();
      force_ = (1 - smooth_step(missed_s)) * force_before_;
    }
    move();
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

  /// Another controller has left so much on every leg (N), and for so many samples the amplifiers
  /// have held it; after ten they begin to let go.
  void leave(double force, std::int64_t held = 10) {
    force_.setConstant(force);
    force_before_ = force_;
    unheard_ = held;
    std::ranges::fill(on_its_way_, force_);
    std::ranges::fill(reports_, force_);
    before_ = force_;
  }

  State state() const { return loop_.counters().state; }
  Fault fault() const { return loop_.counters().fault; }
  bool latched() const { return loop_.counters().latched; }
  const Eigen::VectorXd& force() const { return force_; }
  /// What acts a sample after what acts now; with no delay the same.
  const Eigen::VectorXd& next_force() const { return on_its_way_[on_its_way_.size() > 1 ? 1 : 0]; }
  Loop& loop() { return loop_; }
  const Supervisor& supervisor() const { return loop_.supervisor(); }
  std::int64_t k() const { return k_; }

  const std::int64_t period_ns;
  Floor floor;
  Actuators actuators;
  std::int64_t hold = 10;    ///< samples, for which amplifiers that hear nothing hold a force
  bool deaf = false;         ///< commands do not reach the amplifiers
  Eigen::VectorXd sigma, y;  ///< in the last sample, as they were
  double peak = 0;           ///< of sigma
  double peak_y = 0;         ///< of y
  double largest_force = 0;
  double largest_jump = 0;  ///< of the force between two commands
  bool sent_any = false;    ///< in the last sample

 private:
  /// Noise through a low-pass of 10 Hz: a floor has little at high frequencies.
  void shake(Eigen::VectorXd& w) {
    const double part = 1 - std::exp(-two_pi * 10 * gains_.sample_time());
    // So that its power below the corner does not depend on the sample rate.
    const double size = std::sqrt(gains_.sample_rate_hz / 1000);
    for (double& value : w) value += part * (size * normal_(random_) - value);
  }

  void move() {
    floor(k_, w_);
    on_its_way_.push_back(force_);
    on_its_way_.pop_front();
    Eigen::VectorXd now = on_its_way_.front();
    if (actuators) actuators(now);
    y.noalias() = plant_.C_y * x_ + plant_.D_yw * w_ + plant_.D_0 * before_ + plant_.D_yu * now;
    x_ = (plant_.Phi * x_ + plant_.Gamma_w * w_ + plant_.Gamma_0 * before_ + plant_.Gamma_u * now)
             .eval();
    before_ = now;
  }

  Gains gains_;
  SampledPlant plant_;
  InProcessIo io_;
  Supervisor supervisor_;
  Loop loop_;
  Measurement measurement_;
  Command command_;
  Eigen::VectorXd x_, w_, before_, force_, force_before_;
  std::deque<Eigen::VectorXd> on_its_way_, reports_;  ///< oldest first
  std::int64_t k_ = 0, unheard_ = 0;
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> late_{0, 0.1};
};

namespace toy {

using controller::Rig;

/// The peak of the same frame left alone for so many samples.
inline double passive_peak(int n_samples) {
  Rig rig({}, false);
  rig.steps(n_samples);
  return rig.peak;
}

inline bool nothing(Measurement&) { return false; }

}  // namespace toy
}  // namespace stillframe::controller

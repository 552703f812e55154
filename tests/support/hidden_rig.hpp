#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "controller/rig/probe.hpp"
#include "controller/rig/simulated_plant.hpp"

namespace stillframe::controller {

/// What a rig is like that nobody has told of. Of leg i: its force sensor is on cable sigma[i], and
/// reads gain_sigma(i) times; likewise the others.
struct Hidden {
  explicit Hidden(Eigen::Index m)
      : gain_sigma(Eigen::VectorXd::Ones(m)), gain_applied(gain_sigma), gain_force(gain_sigma) {
    for (Eigen::Index i = 0; i < m; ++i) sigma.push_back(i);
    applied = force = sigma;
  }
  std::vector<Eigen::Index> sigma, applied, force;
  Eigen::VectorXd gain_sigma, gain_applied, gain_force;
  double ppm = 0, noise = 0;  ///< noise: N, of a force sensor
  double frame_noise = 0;     ///< m/s^2
  double step = 0;            ///< of a converter, either way, N
  double lost = 0;            ///< part of the samples
  double late = 0;            ///< part of the commands, which act a sample later
};

/// Its cards and its plant, on a time that does not wait.
class HiddenRig : public Io {
 public:
  /// q: accelerometers of the frame.
  HiddenRig(SimulatedPlant plant, Hidden hidden, unsigned seed, Eigen::Index q = 0)
      : plant_(std::move(plant)),
        hidden_(std::move(hidden)),
        m_(hidden_.gain_sigma.size()),
        random_(seed),
        read_(measurement_of(m_, 0, q)),
        wanted_(Eigen::VectorXd::Zero(m_)),
        acts_(Eigen::VectorXd::Zero(m_)) {}

  ProbeTime time() {
    return {.now_ns = [this] { return now_ns_; },
            .sleep_until_ns =
                [this](std::int64_t until) { now_ns_ = std::max(now_ns_, until + 15'000); }};
  }

  bool receive(Measurement& m) noexcept override {
    const double period_ns = plant_.sample_time() * 1e9 / (1 + 1e-6 * hidden_.ppm);
    const std::int64_t due = 1'000'000'000 + std::llround(static_cast<double>(k_ + 1) * period_ns);
    if (due > now_ns_) return false;
    if (k_ >= 0) plant_.advance(acts_);
    if (is_late_) act();
    ++k_;
    plant_.read(read_);
    for (Eigen::Index leg = 0; leg < m_; ++leg) {
      const auto i = static_cast<std::size_t>(leg);
      const double noise = hidden_.noise * normal_(random_);
      m.sigma(hidden_.sigma[i]) = counts(hidden_.gain_sigma(leg) * read_.sigma(leg) + noise + 3);
      m.applied(hidden_.applied[i]) = counts(hidden_.gain_applied(leg) * read_.applied(leg));
    }
    for (Eigen::Index i = 0; i < m.frame.size(); ++i) {
      m.frame(i) = read_.frame(i) + hidden_.frame_noise * normal_(random_);
    }
    m.seq = k_;
    m.received_ns = due;
    peak = std::max(peak, read_.sigma.cwiseAbs().maxCoeff());
    if (read_.frame.size() > 0)
      frame_peak = std::max(frame_peak, read_.frame.cwiseAbs().maxCoeff());
    if (uniform_(random_) < hidden_.lost) return receive(m);
    return true;
  }
  void send(const Command& command) noexcept override {
    wanted_ = command.force;
    is_late_ = hidden_.late > 0 && uniform_(random_) < hidden_.late;
    n_late += is_late_;
    if (!is_late_) act();
  }
  void enable(bool on) noexcept override { enabled = on; }
  const Eigen::VectorXd& acts() const { return acts_; }

  std::int64_t n_late = 0;  ///< commands that were
  double peak = 0;
  double frame_peak = 0;  ///< m/s^2, as it moves
  bool enabled = false;

 private:
  void act() noexcept {
    is_late_ = false;
    for (Eigen::Index leg = 0; leg < m_; ++leg) {
      acts_(leg) =
          hidden_.gain_force(leg) * counts(wanted_(hidden_.force[static_cast<std::size_t>(leg)]));
    }
  }
  double counts(double value) const {
    return hidden_.step > 0 ? hidden_.step * std::round(value / hidden_.step) : value;
  }

  SimulatedPlant plant_;
  Hidden hidden_;
  Eigen::Index m_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  Measurement read_;
  Eigen::VectorXd wanted_, acts_;
  bool is_late_ = false;
  std::int64_t now_ns_ = 900'000'000, k_ = -1;
};

}  // namespace stillframe::controller

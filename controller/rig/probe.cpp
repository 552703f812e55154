#include "controller/rig/probe.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "controller/deadlines.hpp"
#include "controller/excitation.hpp"
#include "controller/rig/wiring.hpp"
#include "controller/sample_clock.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double silence_s = 1, fade_s = 0.2;
// A force sensor may go so many times as far as the leg is driven.
constexpr double beyond = 10;
// Windows that are tried for each that is kept: of 0.2 s at 1 kHz, so that a machine that stalls
// ten times a second still finds its five, within half a minute a leg.
constexpr double most_trials = 30;

/// Amplitude at a line, through a window of Hann: what moves the floor at other frequencies stays
/// out. Lines two or more apart do not see each other.
std::complex<double> amplitude(const Eigen::Ref<const VectorXd>& values, int line) {
  const auto n = static_cast<double>(values.size());
  std::complex<double> sum = 0;
  for (Index k = 0; k < values.size(); ++k) {
    const double turns = static_cast<double>(k) / n;
    sum += (1 - std::cos(two_pi * turns)) * values(k) * std::polar(1.0, -two_pi * line * turns);
  }
  return 2.0 / n * sum;
}

// Of a window: each costs whoever reads it an unknown of each sensor.
constexpr double most_missing_recorded = 0.01;

/// Rows that are not there, on straight lines between those that are.
void fill_gaps(MatrixXd& values, const std::vector<bool>& there) {
  Index before = -1;
  for (Index k = 0; k < values.rows(); ++k) {
    if (!there[static_cast<std::size_t>(k)]) continue;
    for (Index gap = before + 1; gap < k; ++gap) {
      const double part = static_cast<double>(gap - before) / static_cast<double>(k - before);
      values.row(gap) = before < 0
                            ? values.row(k).eval()
                            : ((1 - part) * values.row(before) + part * values.row(k)).eval();
    }
    before = k;
  }
  for (Index gap = before + 1; before >= 0 && gap < values.rows(); ++gap) {
    values.row(gap) = values.row(before).eval();
  }
}

class Prober {
 public:
  Prober(Io& io, Index m, const ProbeSettings& settings, const ProbeTime& time,
         const std::function<bool()>& stop)
      : io_(io),
        m_(m),
        settings_(settings),
        time_(time),
        stop_(stop),
        clock_(time.now_ns(), settings.sample_rate_hz, Pacing::card),
        deadlines_(time.now_ns(), settings.sample_rate_hz, 0.5),
        measurement_(measurement_of(m, settings.n_floor, settings.n_frame)),
        command_(command_of(m)),
        wave_(settings.force_n * multisine(settings.lines, settings.n_window)),
        mean_(VectorXd::Zero(m)) {}

  ~Prober() { fade(); }
  Prober(const Prober&) = delete;
  Prober& operator=(const Prober&) = delete;

  /// leg: -1, none is driven.
  Response respond(Index leg, const std::function<void(double)>& progress) {
    leg_ = leg;
    const Index n = settings_.n_window;
    const auto n_lines = static_cast<Index>(settings_.lines.size());
    Response response{.command = VectorXcd::Zero(n_lines),
                      .sigma = MatrixXcd::Zero(n_lines, m_),
                      .applied = MatrixXcd::Zero(n_lines, m_),
                      .sigma_scatter = VectorXd::Zero(m_),
                      .sigma_mean = VectorXd::Zero(m_),
                      .sigma_peak = VectorXd::Zero(m_)};
    window(rise);
    window(drive);  // what rang when the force rose has gone by, or repeats
    MatrixXd squares = MatrixXd::Zero(n_lines, m_);
    int kept = 0;
    for (int trial = 0; kept < settings_.n_windows; ++trial) {
      if (trial > most_trials * settings_.n_windows) {
        throw std::runtime_error("too many samples are lost: of " + std::to_string(trial) +
                                 " windows of " + std::to_string(n) + " samples " +
                                 std::to_string(kept) + " are whole");
      }
      if (!window(drive)) continue;
      ++kept;
      for (Index l = 0; l < n_lines; ++l) {
        const int line = settings_.lines[static_cast<std::size_t>(l)];
        response.command(l) += amplitude(sent_, line);
        for (Index j = 0; j < m_; ++j) {
          const auto value = amplitude(sigma_.col(j), line);
          response.sigma(l, j) += value;
          squares(l, j) += std::norm(value);
          response.applied(l, j) += amplitude(applied_.col(j), line);
        }
      }
      const VectorXd mean = sigma_.colwise().mean();
      response.sigma_mean += mean;
      response.sigma_peak = response.sigma_peak.cwiseMax(
          (sigma_.rowwise() - mean.transpose()).cwiseAbs().colwise().maxCoeff().transpose());
      if (progress) progress(static_cast<double>(kept) / settings_.n_windows);
    }
    window(fall);
    const double k = kept;
    response.command /= k;
    response.sigma /= k;
    response.applied /= k;
    response.sigma_mean /= k;
    const MatrixXd variance =
        (squares / k - response.sigma.cwiseAbs2()).cwiseMax(0.0) / std::max(1.0, k - 1);
    response.sigma_scatter = variance.colwise().mean().cwiseSqrt().transpose();
    if (leg < 0) {
      mean_ = response.sigma_mean;
      most_ = settings_.most_n + 10 * response.sigma_peak.maxCoeff();
    }
    return response;
  }

  Recording record(const std::function<void(double)>& progress) {
    const Index n = settings_.n_window, windows = settings_.n_windows;
    const Index rest = recording_margin + 2 * windows * n, part = (windows + 2) * n,
                total = rest + part * m_ + recording_margin;
    Recording out = empty_recording(total, m_, measurement_);
    std::vector<bool> there(static_cast<std::size_t>(total), false);
    std::int64_t first = -1;
    Index k = -1;
    while (k + 1 < total) {
      take([&] {
        if (first < 0) first = measurement_.seq;
        const auto row = static_cast<Index>(measurement_.seq - first);
        if (row >= total) return;
        put(measurement_, row, out);
        there[static_cast<std::size_t>(row)] = true;
      });
      const Index now = first < 0 ? -1 : std::min<Index>(total - 1, last_ - first);
      if (now == k) continue;
      // What was sent last acts until something else is.
      for (Index held = k + 1; held < now; ++held) {
        out.command.row(held) = command_.force.transpose();
      }
      if (now >= rest && leg_ < 0) know_rest(out.sigma, there, rest);
      const Index of_legs = now - rest;
      leg_ = of_legs < 0 || of_legs >= part * m_ ? -1 : of_legs / part;
      const Index at = leg_ < 0 ? 0 : of_legs % part;
      const double up = static_cast<double>(at + 1) / static_cast<double>(n),
                   down = static_cast<double>(part - at - 1) / static_cast<double>(n);
      gain_ = smooth_step(std::min({1.0, up, down}));
      send(at);
      out.command.row(now) = command_.force.transpose();
      if (progress && now / n != k / n) {
        progress(static_cast<double>(now) / static_cast<double>(total));
      }
      k = now;
    }
    choose_windows(out, there, recording_margin, n, 2 * windows, windows, m_,
                   most_missing_recorded);
    out.drift = clock_.drift();
    return out;
  }

  double drift() const { return clock_.drift(); }
  std::int64_t n_samples() const { return n_samples_; }
  std::int64_t n_lost() const { return n_lost_; }

 private:
  enum Part { rise, drive, fall };

  /// Where the force sensors stand while nothing is driven, and how far they go.
  void know_rest(const MatrixXd& sigma, const std::vector<bool>& there, Index n) {
    double count = 0;
    mean_.setZero();
    for (Index k = 0; k < n; ++k) {
      if (!there[static_cast<std::size_t>(k)]) continue;
      mean_ += sigma.row(k).transpose();
      ++count;
    }
    mean_ /= std::max(1.0, count);
    double peak = 0;
    for (Index k = 0; k < n; ++k) {
      if (!there[static_cast<std::size_t>(k)]) continue;
      peak = std::max(peak, (sigma.row(k).transpose() - mean_).cwiseAbs().maxCoeff());
    }
    most_ = settings_.most_n + 10 * peak;
  }

  /// So many samples; false if one of them is missing.
  bool window(Part part) {
    const Index n = settings_.n_window;
    sigma_.setZero(n, m_);
    applied_.setZero(n, m_);
    sent_.setZero(n);
    std::vector<bool> there(static_cast<std::size_t>(n), false);
    const std::int64_t first = next_ < 0 ? -1 : next_;
    std::int64_t from = first;
    Index n_there = 0;
    std::int64_t before = -1;
    while (from < 0 || last_ < from + n - 1) {
      const bool came = take([&] {
        if (from < 0) from = measurement_.seq;
        const std::int64_t k = measurement_.seq - from;
        if (k < 0 || k >= n) return;
        sigma_.row(k) = measurement_.sigma.transpose();
        applied_.row(k) = measurement_.applied.transpose();
        if (!there[static_cast<std::size_t>(k)]) ++n_there;
        there[static_cast<std::size_t>(k)] = true;
      });
      if (!came) continue;
      const std::int64_t k = last_ - from;
      // What was sent last acts until something else is.
      for (std::int64_t held = std::max<std::int64_t>(0, before + 1);
           held < std::min<std::int64_t>(k, n); ++held) {
        sent_(held) = leg_ < 0 ? 0.0 : command_.force(leg_);
      }
      before = k;
      const double p = (static_cast<double>(k) + 1) / static_cast<double>(n);
      gain_ =
          part == drive ? 1 : smooth_step(part == rise ? std::min(1.0, p) : std::max(0.0, 1 - p));
      send(k);
      if (k >= 0 && k < n) sent_(k) = leg_ < 0 ? 0.0 : command_.force(leg_);
    }
    next_ = from + n;
    n_samples_ += n_there;
    n_lost_ += n - n_there;
    return n_there == n;
  }

  /// Sleeps until the next deadline and takes what came; false if nothing did.
  template <class Each>
  bool take(Each each) {
    if (stop_ && stop_()) throw std::runtime_error("interrupted");
    time_.sleep_until_ns(deadlines_.next_ns());
    const std::int64_t now = time_.now_ns();
    deadlines_.wake_up(now);
    io_.beat();
    int n = 0;
    const bool began = clock_.locked();
    while (io_.receive(measurement_)) {
      clock_.see(measurement_);
      // One from the future is one of before that waited in a pipe.
      const double age = clock_.age(measurement_, now) * settings_.sample_rate_hz;
      if (measurement_.seq <= last_ || age < -1) continue;
      last_ = measurement_.seq;
      each();
      ++n;
    }
    if (clock_.locked()) {
      if (!began) deadlines_.begin(clock_.reference_ns(), clock_.reference(), now);
      deadlines_.follow(clock_.reference_ns(), clock_.reference(), clock_.period_ns());
    }
    if (n > 0) heard_ns_ = now;
    if (heard_ns_ == 0) heard_ns_ = now;
    if (static_cast<double>(now - heard_ns_) > silence_s * ns_per_s) {
      throw std::runtime_error("no sample has come for a second");
    }
    if (leg_ >= 0 && n > 0) {
      Index worst = 0;
      const double most = (measurement_.sigma - mean_).cwiseAbs().maxCoeff(&worst);
      if (!(most <= most_)) {
        throw TooFar("the force in leg " + std::to_string(worst + 1) + " was " +
                     std::to_string(most) + " N from its mean, allowed are " +
                     std::to_string(most_) + " N");
      }
    }
    return n > 0;
  }

  /// The multisine at sample k of a window.
  void send(std::int64_t k) {
    command_.force.setZero();
    const Index n = wave_.size();
    if (leg_ >= 0) command_.force(leg_) = gain_ * wave_((k % n + n) % n);
    if (!enabled_) io_.enable(true);
    enabled_ = true;
    command_.seq = last_;
    command_.time_ns = measurement_.time_ns;
    io_.send(command_);
  }

  /// Whatever went wrong, the force goes to nothing in a fifth of a second.
  void fade() noexcept {
    const VectorXd from = command_.force;
    const auto n = static_cast<int>(fade_s * settings_.sample_rate_hz);
    if (enabled_ && from.cwiseAbs().maxCoeff() > 0) {
      for (int i = 1; i <= n; ++i) {
        time_.sleep_until_ns(deadlines_.next_ns());
        deadlines_.wake_up(time_.now_ns());
        while (io_.receive(measurement_)) {
        }
        io_.beat();
        command_.force = smooth_step(1 - static_cast<double>(i) / n) * from;
        io_.send(command_);
      }
    }
    if (enabled_) io_.enable(false);
    io_.beat();
  }

  Io& io_;
  Index m_;
  const ProbeSettings& settings_;
  const ProbeTime& time_;
  const std::function<bool()>& stop_;
  SampleClock clock_;
  Deadlines deadlines_;
  Measurement measurement_;
  Command command_;
  VectorXd wave_, mean_, sent_;
  MatrixXd sigma_, applied_;  ///< samples x m
  Index leg_ = -1;
  double gain_ = 0, most_ = 0;
  bool enabled_ = false;
  std::int64_t last_ = -1, next_ = -1, heard_ns_ = 0, n_samples_ = 0, n_lost_ = 0;
};

}  // namespace

Recording empty_recording(Index n, Index m, const Measurement& measurement) {
  Recording recording;
  recording.command = recording.sigma = recording.applied = MatrixXd::Zero(n, m);
  recording.frame = MatrixXd::Zero(n, measurement.frame.size());
  recording.floor = MatrixXd::Zero(n, measurement.floor.size());
  return recording;
}

void put(const Measurement& measurement, Index row, Recording& recording) {
  recording.sigma.row(row) = measurement.sigma.transpose();
  recording.applied.row(row) = measurement.applied.transpose();
  recording.frame.row(row) = measurement.frame.transpose();
  recording.floor.row(row) = measurement.floor.transpose();
}

void choose_windows(Recording& recording, const std::vector<bool>& there, Index from, Index n,
                    Index at_rest, Index windows, Index m, double most_missing) {
  for (Index leg = -1; leg < m; ++leg) {
    const Index of_leg = leg < 0 ? from : from + (at_rest + leg * (windows + 2) + 1) * n,
                most = leg < 0 ? at_rest : windows;
    Index kept = 0;
    for (Index w = 0; w < most; ++w) {
      const auto begin = there.begin() + of_leg + w * n;
      if (std::count(begin, begin + n, false) > most_missing * static_cast<double>(n)) continue;
      recording.windows.push_back(of_leg + w * n);
      recording.driven.push_back(leg);
      ++kept;
    }
    if (kept < std::min<Index>(2, most)) {
      throw std::runtime_error("too many samples are lost: of " + std::to_string(most) +
                               " windows of " + std::to_string(n) + " samples " +
                               std::to_string(kept) + " are whole");
    }
  }
  for (MatrixXd* values :
       {&recording.sigma, &recording.applied, &recording.frame, &recording.floor}) {
    fill_gaps(*values, there);
  }
  recording.missing = there;
  recording.missing.flip();
  recording.n_samples = std::count(there.begin(), there.end(), true);
  recording.n_lost = static_cast<std::int64_t>(there.size()) - recording.n_samples;
}

double probe_force(const std::optional<double>& asked, const Gains& gains,
                   const std::filesystem::path& source) {
  if (!gains.force_limit_n && !asked) {
    throw InputError(source.string() + ": force_limit_n: missing; say --force in N");
  }
  const double force = asked.value_or(small_force * gains.force_limit_n.value_or(0));
  if (gains.force_limit_n && force > *gains.force_limit_n) {
    throw InputError("--force: found " + shortest_digits(force) + ", allowed is up to " +
                     shortest_digits(*gains.force_limit_n) + ", the force limit of the loop");
  }
  return force;
}

ProbeSettings probe_settings(const Gains& gains, const Channels& channels, double force_n) {
  ProbeSettings settings;
  settings.sample_rate_hz = gains.sample_rate_hz;
  settings.force_n = force_n;
  settings.most_n = beyond * force_n;
  settings.lines = probe_lines(settings.n_window);
  settings.n_floor = static_cast<Index>(channels.floor.size());
  settings.n_frame = static_cast<Index>(channels.frame.size());
  return settings;
}

ProbeTime real_time() {
  return {.now_ns = [] { return monotonic_ns(); },
          .sleep_until_ns = [](std::int64_t time_ns) { sleep_until(time_ns); }};
}

Probe probe_rig(Io& io, Index m, const ProbeSettings& settings, const ProbeTime& time,
                const std::function<void(double)>& progress, const std::function<bool()>& stop) {
  Prober prober(io, m, settings, time, stop);
  Probe probe;
  const auto part = [&](Index i) {
    return [&, i](double done) {
      if (progress) progress((static_cast<double>(i) + done) / static_cast<double>(m + 1));
    };
  };
  probe.rest = prober.respond(-1, part(0));
  for (Index leg = 0; leg < m; ++leg) probe.legs.push_back(prober.respond(leg, part(leg + 1)));
  probe.drift = prober.drift();
  probe.n_samples = prober.n_samples();
  probe.n_lost = prober.n_lost();
  return probe;
}

Recording record_rig(Io& io, Index m, const ProbeSettings& settings, const ProbeTime& time,
                     const std::function<void(double)>& progress,
                     const std::function<bool()>& stop) {
  return Prober(io, m, settings, time, stop).record(progress);
}

}  // namespace stillframe::controller

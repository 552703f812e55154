#include "controller/excitation.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/low_crest.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double fewest_samples = 20, most_samples = 1e6;  // of a window
constexpr double highest_to = 0.49;                        // of the sample rate

/// A sine whose frequency rises by the same factor in the same time, from nothing to nothing in a
/// tenth of the window at each end. from, to: periods in a window.
VectorXd sweep(double from, double to, Index n) {
  constexpr double edge = 0.1;
  const double rises = std::log(to / from);
  VectorXd wave(n);
  for (Index k = 0; k < n; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(n);
    const double turns = from / rises * std::expm1(rises * part);
    const double taper = smooth_step(std::min({1.0, part / edge, (1 - part) / edge}));
    wave(k) = taper * std::sin(two_pi * turns);
  }
  return wave;
}

/// The whole force for half a window, and none for the other.
VectorXd step(Index n) {
  VectorXd wave = VectorXd::Zero(n);
  wave.head(n / 2).setOnes();
  return wave;
}

}  // namespace

std::vector<int> logarithmic_lines(double from, double to, int n_lines,
                                   const std::function<bool(int)>& avoid) {
  const double first = std::ceil(from - 1e-9);
  std::vector<int> lines;
  if (!(first <= to)) return lines;
  for (int i = 0; i < n_lines; ++i) {
    const double part = n_lines > 1 ? i / static_cast<double>(n_lines - 1) : 0;
    int line = static_cast<int>(std::lround(first * std::pow(to / first, part)));
    if (!lines.empty()) line = std::max(line, lines.back() + 1);
    if (line <= to + 1e-9 && !(avoid && avoid(line))) lines.push_back(line);
  }
  return lines;
}

VectorXd multisine(const std::vector<int>& lines, Index n_window) {
  VectorXd wave = VectorXd::Zero(n_window);
  // A tenth of a second or two: a loop that is to be excited does not wait for the last of it.
  const VectorXd phases = low_crest_phases({lines.begin(), lines.end()}, 1, std::size_t{1} << 22);
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const double phase = phases(static_cast<Index>(l));
    for (Index k = 0; k < n_window; ++k) {
      const auto turns =
          static_cast<double>((lines[l] * k) % n_window) / static_cast<double>(n_window);
      wave(k) += std::cos(two_pi * turns + phase);
    }
  }
  return wave / wave.cwiseAbs().maxCoeff();
}

Excitation::Excitation(const Gains& gains, const Policy& policy)
    : force_(VectorXd::Zero(gains.n_legs())), reach_(force_) {
  using Kind = ExcitationPlan::Kind;
  const ExcitationPlan& plan = policy.excitation;
  if (plan.kind == Kind::none) return;
  const double rate_hz = gains.sample_rate_hz, samples = std::round(plan.window_s * rate_hz);
  const std::string place = plan.place.empty() ? "" : plan.place + ": ";
  const auto refuse = [&](const char* key, double found, const std::string& allowed) {
    throw InputError(place + "excitation." + key + ": found " + shortest_digits(found) +
                     ", allowed is a number " + allowed);
  };
  if (!(samples >= fewest_samples && samples <= most_samples)) {
    refuse("window_s", plan.window_s,
           "from " + shortest_digits(fewest_samples / rate_hz) + " to " +
               shortest_digits(most_samples / rate_hz) + " at " + shortest_digits(rate_hz) + " Hz");
  }
  const double line_hz = rate_hz / samples, from_hz = plan.from_hz.value_or(lowest_line * line_hz),
               to_hz = plan.to_hz.value_or(driven_up_to * rate_hz);
  if (!(from_hz >= line_hz && from_hz < to_hz)) {
    refuse("from_hz", from_hz,
           "from " + shortest_digits(line_hz) + ", one period in a window, to below to_hz");
  }
  if (!(to_hz <= highest_to * rate_hz)) {
    refuse("to_hz", to_hz, "up to " + shortest_digits(highest_to * rate_hz));
  }
  const double limit = force_limit(gains, policy),
               force_n = plan.force_n.value_or(small_force * limit);
  if (!(force_n < limit)) {
    refuse("force_n", force_n, "below the force limit, " + shortest_digits(limit));
  }
  const auto n = static_cast<Index>(samples);
  if (plan.kind == Kind::multisine) {
    lines_ = logarithmic_lines(from_hz / line_hz, to_hz / line_hz, static_cast<int>(plan.lines));
    if (lines_.empty()) {
      refuse("to_hz", to_hz,
             "from the next multiple of " + shortest_digits(line_hz) +
                 " Hz above from_hz on, whole periods in a window");
    }
    wave_ = multisine(lines_, n);
  } else {
    wave_ = plan.kind == Kind::sweep ? sweep(from_hz / line_hz, to_hz / line_hz, n) : step(n);
  }
  wave_ *= force_n;
  peak_ = force_n;
  open_loop_ = plan.open_loop;
  n_windows_ = plan.windows;
  n_samples_ = n * (n_windows_ + (n_windows_ + 2) * gains.n_legs());
}

const VectorXd& Excitation::at(std::int64_t seq) noexcept {
  force_.setZero();
  reach_.setZero();
  if (start_ < 0) return force_;
  const std::int64_t n = wave_.size(), part = (n_windows_ + 2) * n,
                     of_legs = seq - start_ - n_windows_ * n;
  if (of_legs < 0 || of_legs >= part * force_.size()) return force_;
  const std::int64_t k = of_legs % part;
  const double up = static_cast<double>(k + 1) / static_cast<double>(n),
               down = static_cast<double>(part - k - 1) / static_cast<double>(n);
  const double size = smooth_step(std::min({1.0, up, down}));
  force_(of_legs / part) = size * wave_(k % n);
  reach_(of_legs / part) = size * peak_;
  return force_;
}

}  // namespace stillframe::controller

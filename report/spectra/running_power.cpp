#include "report/spectra/running_power.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <kissfft/kissfft.hh>
#include <optional>
#include <stdexcept>
#include <string>

#include "report/spectra/fourier.hpp"
#include "report/spectra/windows.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index parts = 5;               ///< of a window, that the next one is further
constexpr double overlap = 175.0 / 128;  ///< sum of the squares of all windows over a sample
constexpr Index longest_window = Index{1} << 20;
constexpr double least_periods = 200, fewest_periods = 24;

/// The shortest window that n samples fit into, of an even number that transforms are fast for.
Index window_for(Index n) {
  Index half = std::max<Index>(1, (n + 2 * parts - 1) / (2 * parts));
  while (fast_length(half) != half) ++half;
  return 2 * parts * half;
}

struct Transform {
  explicit Transform(Index n)
      : window(hann_squared(n)), plan(static_cast<std::size_t>(n / 2), false) {}

  VectorXd window;
  kissfft<double> plan;
};

/// Of n samples. A long run has many signals: were each to keep its own, all would stay. They come
/// one behind the other and of one length, so that the last one is mostly the next.
const Transform& transform_of(Index n) {
  thread_local std::optional<Transform> last;
  if (!last || last->window.size() != n) last.emplace(n);
  return *last;
}

}  // namespace

/// The windows over one signal, of which the last n samples are held.
class RunningPower::Windows {
 public:
  Windows(Index n, Index beside, const std::vector<double>& first)
      : held_(VectorXd::Zero(n)),
        filled_(n - n / parts),
        beside_(beside),
        power_(VectorXd::Zero(n / 2 + 1)) {
    const Eigen::Map<const VectorXd> x(first.data(), static_cast<Index>(first.size()));
    mean_ = x.mean();
    add(x);
  }

  void add(const Eigen::Ref<const VectorXd>& x) {
    if (x.size() == 0) return;
    count_ += x.size();
    if (apart_) jumps_ += std::pow(x(0) - mean_, 2);
    apart_ = false;
    last_ = x(x.size() - 1) - mean_;
    for (Index begin = 0; begin < x.size();) {
      const Index part = std::min(x.size() - begin, held_.size() - filled_);
      held_.segment(filled_, part) = x.segment(begin, part).array() - mean_;
      weigh(held_.segment(filled_, part));
      begin += part;
      move_on(part);
    }
  }

  /// Zeros; behind a whole window of them nothing is left to be said.
  void add_nothing(std::int64_t n) {
    if (!apart_) {
      jumps_ += last_ * last_;
      end_stretch();
    }
    apart_ = true;
    for (Index rest = std::min<std::int64_t>(n, held_.size()); rest > 0;) {
      const Index part = std::min(rest, held_.size() - filled_);
      held_.segment(filled_, part).setZero();
      rest -= part;
      move_on(part);
    }
  }

  Psd finish(double sample_rate_hz) const {
    Windows last = *this;
    last.add_nothing(held_.size());
    const Index n = held_.size();
    Psd psd{.sample_rate_hz = sample_rate_hz,
            .resolution_hz = sample_rate_hz / static_cast<double>(n),
            .density = last.power_ * (2 / (sample_rate_hz * overlap * static_cast<double>(count_))),
            .duration_s = static_cast<double>(count_) / sample_rate_hz,
            .jumps = last.jumps_,
            .ends = last.ends_};
    psd.density(0) *= 0.5;
    psd.density(n / 2) *= 0.5;
    return psd;
  }

 private:
  /// Mean squares beside the beginning of a stretch and, forgetting, up to now.
  void weigh(const Eigen::Ref<const VectorXd>& x) {
    const auto beside = static_cast<double>(beside_);
    for (const double value : x) {
      const double square = value * value;
      if (stretch_ < beside_) begin_ += square;
      ++stretch_;
      recent_ += (square - recent_) / std::min(beside, static_cast<double>(stretch_));
    }
  }
  void end_stretch() {
    ends_ += begin_ / static_cast<double>(std::min(beside_, stretch_)) + recent_;
    begin_ = recent_ = 0;
    stretch_ = 0;
  }

  void move_on(Index part) {
    filled_ += part;
    if (filled_ < held_.size()) return;
    const Index n = held_.size();
    const Transform& transform = transform_of(n);
    VectorXd piece = held_.cwiseProduct(transform.window);
    Eigen::VectorXcd spectrum(n / 2);
    transform.plan.transform_real(piece.data(), spectrum.data());
    power_(0) += std::pow(spectrum(0).real(), 2);
    power_(n / 2) += std::pow(spectrum(0).imag(), 2);
    power_.segment(1, n / 2 - 1) += spectrum.tail(n / 2 - 1).cwiseAbs2();
    const Index step = n / parts;
    filled_ -= step;
    held_.head(filled_) = held_.tail(filled_).eval();
  }

  VectorXd held_;
  Index filled_, beside_, count_ = 0, stretch_ = 0;
  double mean_ = 0, last_ = 0, jumps_ = 0, begin_ = 0, recent_ = 0, ends_ = 0;
  bool apart_ = true;  ///< nothing stands before the next sample
  VectorXd power_;
};

RunningPower::RunningPower(double sample_rate_hz, double lowest_hz, std::int64_t expected)
    : sample_rate_hz_(sample_rate_hz) {
  if (!(sample_rate_hz > 0) || !(lowest_hz > 0)) {
    throw std::invalid_argument("RunningPower: sample rate " + std::to_string(sample_rate_hz) +
                                ", lowest frequency " + std::to_string(lowest_hz));
  }
  const double period = sample_rate_hz / lowest_hz;
  const auto most = static_cast<double>(longest_window);
  const double longest = std::min(least_periods * period, most);
  shortest_ = static_cast<Index>(std::min(fewest_periods * period, most));
  n_ = window_for(static_cast<Index>(longest));
  if (expected > 0) n_ = std::min(n_, window_for(std::max<Index>(shortest_, expected)));
  beside_ = static_cast<Index>(std::clamp(2 * period, 1.0, static_cast<double>(n_)));
}

RunningPower::~RunningPower() = default;
RunningPower::RunningPower(RunningPower&&) noexcept = default;
RunningPower& RunningPower::operator=(RunningPower&&) noexcept = default;

void RunningPower::add(const Eigen::Ref<const VectorXd>& x) {
  Index begin = 0;
  if (!windows_) {
    begin = std::min<Index>(x.size(), n_ - static_cast<Index>(first_.size()));
    first_.insert(first_.end(), x.begin(), x.begin() + begin);
    if (static_cast<Index>(first_.size()) < n_) return;
    windows_ = std::make_unique<Windows>(n_, beside_, first_);
    first_ = {};
  }
  windows_->add(x.tail(x.size() - begin));
}

void RunningPower::skip(std::int64_t n) {
  if (n <= 0) return;
  if (!windows_) {
    if (first_.empty()) return;
    windows_ = std::make_unique<Windows>(n_, beside_, first_);
    first_ = {};
  }
  windows_->add_nothing(n);
}

Psd RunningPower::finish() const {
  if (windows_) return windows_->finish(sample_rate_hz_);
  const auto n = static_cast<Index>(first_.size());
  if (n < 2) return {.sample_rate_hz = sample_rate_hz_, .resolution_hz = 0, .density = {}};
  return Windows(std::min(n_, window_for(std::max(shortest_, n))), beside_, first_)
      .finish(sample_rate_hz_);
}

Psd power_of(const VectorXd& x, double sample_rate_hz, double lowest_hz) {
  RunningPower power(sample_rate_hz, lowest_hz, x.size());
  power.add(x);
  return power.finish();
}

}  // namespace stillframe::report

#include "report/analysis/signal_analyser.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::report {

namespace {

double root_mean(double sum, std::int64_t count) {
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

/// Segments of default_segment_s; a shorter run is one segment of its own length.
Eigen::Index segment_of(double sample_rate_hz) {
  return default_segment_length(std::numeric_limits<Eigen::Index>::max(), sample_rate_hz);
}

}  // namespace

SignalAnalyser::SignalAnalyser(double sample_rate_hz, double first_time_s, double lowest_hz,
                               std::int64_t expected)
    : density_(sample_rate_hz, segment_of(sample_rate_hz)),
      power_(sample_rate_hz, lowest_hz, expected),
      envelope_(1 / sample_rate_hz, first_time_s),
      levels_(sample_rate_hz) {}

void SignalAnalyser::add(const Eigen::Ref<const Eigen::VectorXd>& x) {
  if (x.size() == 0) return;
  density_.add(x);
  power_.add(x);
  envelope_.add(x);
  levels_.add(x);
  sum_ += x.squaredNorm();
  peak_ = std::max(peak_, x.cwiseAbs().maxCoeff());
  count_ += x.size();
}

void SignalAnalyser::skip(std::int64_t n) {
  density_.interrupt();
  power_.skip(n);
  envelope_.skip(n);
  levels_.skip(n);
}

SignalAnalysis SignalAnalyser::finish() const {
  SignalAnalysis result{.rms = root_mean(sum_, count_),
                        .peak = peak_,
                        .density = density_.finish(),
                        .power = power_.finish(),
                        .third_octaves = {},
                        .envelope = envelope_.finish(),
                        .levels = levels_.levels()};
  if (result.density.density.size() > 0) {
    result.third_octaves = third_octave_velocity(result.power);
  }
  return result;
}

SignalAnalysis analyse_signal(const Eigen::VectorXd& x, double sample_rate_hz) {
  SignalAnalyser analyser(sample_rate_hz, 0, 1, x.size());
  analyser.add(x);
  return analyser.finish();
}

LegAnalyser::LegAnalyser(std::string name, double sample_rate_hz, double first_time_s)
    : envelope_(1 / sample_rate_hz, first_time_s, page::EnvelopeBuilder::default_parts / 4) {
  result_.name = std::move(name);
}

void LegAnalyser::add(const Eigen::Ref<const Eigen::VectorXd>& applied,
                      const Eigen::Ref<const Eigen::VectorXd>& sigma,
                      const Eigen::Ref<const Eigen::VectorXd>& command) {
  if (applied.size() == 0) return;
  envelope_.add(applied);
  applied_sum_ += applied.squaredNorm();
  sigma_sum_ += sigma.squaredNorm();
  count_ += applied.size();
  result_.applied_peak = std::max(result_.applied_peak, applied.cwiseAbs().maxCoeff());
  result_.sigma_peak = std::max(result_.sigma_peak, sigma.cwiseAbs().maxCoeff());
  for (const double force : command) {
    if (std::abs(force) > result_.command_peak) result_.command_peak = std::abs(force);
  }
}

void LegAnalyser::skip(std::int64_t n) { envelope_.skip(n); }

LegAnalysis LegAnalyser::finish() const {
  LegAnalysis result = result_;
  result.applied_rms = root_mean(applied_sum_, count_);
  result.sigma_rms = root_mean(sigma_sum_, count_);
  result.applied = envelope_.finish();
  return result;
}

}  // namespace stillframe::report

#include "report/spectra/spectra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <kissfft/kissfft.hh>
#include <numbers>
#include <stdexcept>
#include <string>

#include "report/spectra/windows.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The part of the axis that bin k stands for, within 0 and half the sample rate.
struct BinExtent {
  double lower_hz, upper_hz;
};

BinExtent extent_of(const Psd& psd, Index k) {
  const double centre = psd.frequency_hz(k), half = 0.5 * psd.resolution_hz;
  return {std::max(0.0, centre - half), std::min(0.5 * psd.sample_rate_hz, centre + half)};
}

}  // namespace

Index default_segment_length(Index n_samples, double sample_rate_hz) {
  return std::min(n_samples, static_cast<Index>(std::lround(default_segment_s * sample_rate_hz)));
}

struct RunningWelch::Transform {
  explicit Transform(Index n)
      : window(hann(n)), fft(static_cast<std::size_t>(n), false), piece(n), spectrum(n) {}
  VectorXd window;
  kissfft<double> fft;
  Eigen::VectorXcd piece, spectrum;
};

RunningWelch::RunningWelch(double sample_rate_hz, Index segment_length)
    : sample_rate_hz_(sample_rate_hz) {
  if (segment_length < 2 || !(sample_rate_hz > 0)) {
    throw std::invalid_argument("RunningWelch: segment_length must be 2 or more, got " +
                                std::to_string(segment_length) + ", at a rate of " +
                                std::to_string(sample_rate_hz));
  }
  transform_ = std::make_unique<Transform>(segment_length);
  segment_.resize(segment_length);
  power_.setZero(segment_length / 2 + 1);
}

RunningWelch::~RunningWelch() = default;
RunningWelch::RunningWelch(RunningWelch&&) noexcept = default;
RunningWelch& RunningWelch::operator=(RunningWelch&&) noexcept = default;

void RunningWelch::take(const Eigen::Ref<const VectorXd>& piece, Transform& transform,
                        VectorXd& power) const {
  transform.piece =
      ((piece.array() - piece.mean()) * transform.window.array()).cast<std::complex<double>>();
  transform.fft.transform(transform.piece.data(), transform.spectrum.data());
  power += transform.spectrum.head(power.size()).cwiseAbs2();
}

void RunningWelch::add(const Eigen::Ref<const VectorXd>& x) {
  const Index n = segment_.size(), step = n - n / 2;
  for (Index begin = 0; begin < x.size();) {
    const Index part = std::min(x.size() - begin, n - filled_);
    segment_.segment(filled_, part) = x.segment(begin, part);
    filled_ += part;
    begin += part;
    if (filled_ < n) break;
    take(segment_, *transform_, power_);
    ++n_segments_;
    segment_.head(n - step) = segment_.tail(n - step).eval();
    filled_ = n - step;
  }
}

void RunningWelch::interrupt() {
  if (n_segments_ == 0 && filled_ > longest_.size()) longest_ = segment_.head(filled_);
  filled_ = 0;
}

Psd RunningWelch::finish() const {
  VectorXd power = power_;
  double norm = transform_->window.squaredNorm();
  Index n = segment_.size();
  if (n_segments_ == 0) {
    const VectorXd piece = filled_ > longest_.size() ? VectorXd(segment_.head(filled_)) : longest_;
    n = piece.size();
    if (n < 2) return {.sample_rate_hz = sample_rate_hz_, .resolution_hz = 0, .density = {}};
    Transform shorter(n);
    power.setZero(n / 2 + 1);
    take(piece, shorter, power);
    norm = shorter.window.squaredNorm();
  }
  const auto count = static_cast<double>(std::max<Index>(n_segments_, 1));
  Psd psd{.sample_rate_hz = sample_rate_hz_,
          .resolution_hz = sample_rate_hz_ / static_cast<double>(n),
          .density = power * (2 / (sample_rate_hz_ * norm * count))};
  psd.density(0) *= 0.5;
  if (n % 2 == 0) psd.density(n / 2) *= 0.5;
  return psd;
}

Psd welch(const VectorXd& x, double sample_rate_hz, Index segment_length) {
  if (segment_length > x.size()) {
    throw std::invalid_argument("welch: segment_length must be 2 to " + std::to_string(x.size()) +
                                ", got " + std::to_string(segment_length));
  }
  RunningWelch estimate(sample_rate_hz, segment_length);
  estimate.add(x);
  return estimate.finish();
}

Psd velocity_from_acceleration(const Psd& acceleration) {
  Psd velocity = acceleration;
  velocity.density(0) = 0;
  for (Index k = 1; k < velocity.density.size(); ++k) {
    const double omega = 2 * std::numbers::pi * velocity.frequency_hz(k);
    velocity.density(k) /= omega * omega;
  }
  return velocity;
}

double band_rms(const Psd& psd, double lower_hz, double upper_hz) {
  double power = 0;
  for (Index k = 0; k < psd.density.size(); ++k) {
    const BinExtent bin = extent_of(psd, k);
    const double overlap = std::min(bin.upper_hz, upper_hz) - std::max(bin.lower_hz, lower_hz);
    if (overlap <= 0) continue;
    // The bins at 0 and at half the rate are half as wide but hold the power of a whole one.
    power += psd.density(k) * psd.resolution_hz * overlap / (bin.upper_hz - bin.lower_hz);
  }
  return std::sqrt(power);
}

VectorXd cumulative_rms(const Psd& psd) {
  VectorXd rms(psd.density.size());
  double power = 0;
  for (Index k = 0; k < rms.size(); ++k) {
    power += psd.density(k) * psd.resolution_hz;
    rms(k) = std::sqrt(power);
  }
  return rms;
}

std::vector<OctaveBand> third_octave_bands() {
  constexpr std::array nominal = {1.0,  1.25, 1.6,  2.0,  2.5,  3.15, 4.0,  5.0,  6.3,  8.0,
                                  10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0, 50.0, 63.0, 80.0};
  std::vector<OctaveBand> bands;
  for (std::size_t n = 0; n < nominal.size(); ++n) {
    const double exponent = 0.1 * static_cast<double>(n);
    bands.push_back({.nominal_hz = nominal[n],
                     .centre_hz = std::pow(10, exponent),
                     .lower_hz = std::pow(10, exponent - 0.05),
                     .upper_hz = std::pow(10, exponent + 0.05)});
  }
  return bands;
}

VectorXd third_octave_velocity(const Psd& acceleration) {
  const Psd velocity = velocity_from_acceleration(acceleration);
  const std::vector<OctaveBand> bands = third_octave_bands();
  VectorXd rms(static_cast<Index>(bands.size()));
  for (std::size_t i = 0; i < bands.size(); ++i) {
    rms(static_cast<Index>(i)) = band_rms(velocity, bands[i].lower_hz, bands[i].upper_hz);
  }
  return rms;
}

}  // namespace stillframe::report

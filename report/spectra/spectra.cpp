#include "report/spectra/spectra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <kissfft/kissfft.hh>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/numerics/two_pi.hpp"
#include "report/spectra/fourier.hpp"
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

/// n, or up to 6 % less: of a length with a large prime factor the transform takes a thousand times
/// as long (12 007 samples: 0.4 s), of less than a thousand samples no time at all.
Index quick_segment(Index n) { return n < 1000 ? n : fast_length(n); }

}  // namespace

Index default_segment_length(Index n_samples, double sample_rate_hz) {
  const auto whole = static_cast<Index>(std::lround(default_segment_s * sample_rate_hz));
  return quick_segment(std::min(n_samples, whole));
}

struct RunningWelch::Transform {
  explicit Transform(Index n)
      : window(hann(n)), fft(static_cast<std::size_t>(n), false), piece(n), spectrum(n) {}
  VectorXd window;
  kissfft<double> fft;
  Eigen::VectorXcd piece, spectrum;
};

RunningWelch::RunningWelch(double sample_rate_hz, Index segment_length)
    : sample_rate_hz_(sample_rate_hz), length_(segment_length) {
  if (segment_length < 2 || !(sample_rate_hz > 0)) {
    throw std::invalid_argument("RunningWelch: segment_length must be 2 or more, got " +
                                std::to_string(segment_length) + ", at a rate of " +
                                std::to_string(sample_rate_hz));
  }
}

RunningWelch::~RunningWelch() = default;
RunningWelch::RunningWelch(RunningWelch&&) noexcept = default;
RunningWelch& RunningWelch::operator=(RunningWelch&&) noexcept = default;

void RunningWelch::take(const Eigen::Ref<const VectorXd>& piece, Transform& transform,
                        VectorXd& power) const {
  // As the window weighs it: another mean would stand in the lowest two bins, far above what a
  // floor has there.
  const double mean = piece.dot(transform.window) / transform.window.sum();
  transform.piece =
      ((piece.array() - mean) * transform.window.array()).cast<std::complex<double>>();
  transform.fft.transform(transform.piece.data(), transform.spectrum.data());
  power += transform.spectrum.head(power.size()).cwiseAbs2();
}

void RunningWelch::add(const Eigen::Ref<const VectorXd>& x) {
  const Index n = length_, step = n - n / 2;
  for (Index begin = 0; begin < x.size();) {
    const Index part = std::min(x.size() - begin, n - filled_);
    if (segment_.size() < filled_ + part) {
      segment_.conservativeResize(std::min(n, std::max(filled_ + part, 2 * filled_)));
    }
    segment_.segment(filled_, part) = x.segment(begin, part);
    filled_ += part;
    begin += part;
    if (filled_ < n) break;
    if (!transform_) {
      transform_ = std::make_unique<Transform>(n);
      power_.setZero(n / 2 + 1);
    }
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
  Index n = length_;
  double norm = 0;
  if (n_segments_ > 0) {
    norm = transform_->window.squaredNorm();
  } else {
    const VectorXd whole = filled_ > longest_.size() ? VectorXd(segment_.head(filled_)) : longest_;
    n = quick_segment(whole.size());
    if (n < 2) return {.sample_rate_hz = sample_rate_hz_, .resolution_hz = 0, .density = {}};
    const VectorXd piece = whole.head(n);
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
    const double omega = two_pi * velocity.frequency_hz(k);
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

VectorXd band_powers(const Psd& psd, const VectorXd& edges_hz) {
  VectorXd powers = VectorXd::Zero(edges_hz.size() - 1);
  Index band = 0;
  for (Index k = 0; k < psd.density.size(); ++k) {
    const BinExtent bin = extent_of(psd, k);
    const double density = psd.density(k) * psd.resolution_hz / (bin.upper_hz - bin.lower_hz);
    while (band < powers.size() && edges_hz(band + 1) <= bin.lower_hz) ++band;
    for (Index i = band; i < powers.size() && edges_hz(i) < bin.upper_hz; ++i) {
      powers(i) += density * std::max(0.0, std::min(bin.upper_hz, edges_hz(i + 1)) -
                                               std::max(bin.lower_hz, edges_hz(i)));
    }
  }
  return powers;
}

double jumps_in_band(const Psd& psd, double lower_hz, double upper_hz) {
  if (!(psd.jumps > 0)) return psd.jumps;
  const double lowest = std::max(lower_hz, psd.resolution_hz);
  if (!(lowest < upper_hz)) return 0;
  return std::sqrt(psd.jumps / (two_pi * std::numbers::pi * psd.duration_s) *
                   (1 / lowest - 1 / upper_hz));
}

double leak_in_band(const Psd& psd, double lower_hz, double upper_hz) {
  const double total = psd.density.sum() * psd.resolution_hz;
  if (!(psd.duration_s > 0) || !(total > 0)) return total > 0 ? 0 : total;
  // A tone a cos(w t) that breaks off has the one-sided density 2 / T (a / 2)^2 / (w - w')^2.
  const double broken_off =
      psd.ends / total / (4 * std::numbers::pi * std::numbers::pi * psd.duration_s);
  const double width = psd.resolution_hz;
  const auto beyond = [&](double distance_hz) {
    return beyond_lobe(distance_hz / width) + broken_off / std::max(distance_hz, width);
  };
  const double jumps = lower_hz > 0 ? broken_off / lower_hz : 0;
  double in = 0, out = 0;
  for (Index k = 0; k < psd.density.size(); ++k) {
    const double f = psd.frequency_hz(k), power = psd.density(k) * width;
    if (f < lower_hz) {
      in += power * std::max(0.0, beyond(lower_hz - f) - jumps);
    } else if (f > upper_hz) {
      in += power * beyond(f - upper_hz);
    } else {
      out += power * std::min(1.0, beyond(f - lower_hz) + beyond(upper_hz - f));
    }
  }
  return std::sqrt(std::max(in, out));
}

double narrowest_band_hz(const Psd& psd) { return 6 * psd.resolution_hz; }

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
    const bool observed = bands[i].upper_hz <= 0.5 * acceleration.sample_rate_hz;
    rms(static_cast<Index>(i)) = observed ? band_rms(velocity, bands[i].lower_hz, bands[i].upper_hz)
                                          : std::numeric_limits<double>::quiet_NaN();
  }
  return rms;
}

}  // namespace stillframe::report

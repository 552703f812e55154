#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace stillframe::report {

/// A one-sided power spectral density at the frequencies 0, df, 2 df, ... up to half the sample
/// rate.
struct Psd {
  double sample_rate_hz = 0;  ///< Hz
  double resolution_hz = 0;   ///< df, Hz
  Eigen::VectorXd density;    ///< unit^2 / Hz
  // Of RunningPower alone, whose windows the bounds below hold for.
  double duration_s = 0;  ///< of the samples
  /// unit^2, sum of the squares of the jumps where the signal begins, ends or has a gap.
  double jumps = 0;
  /// unit^2, sum of the mean squares beside those places.
  double ends = 0;

  double frequency_hz(Eigen::Index k) const { return resolution_hz * static_cast<double>(k); }
};

/// Segment length for vibration spectra, s: the one-third-octave band at 1 Hz then spans nearly
/// four bins.
inline constexpr double default_segment_s = 16;

/// The number of samples in default_segment_s, or all of them if there are fewer; of a thousand and
/// more the next number down that transforms are quick for.
Eigen::Index default_segment_length(Eigen::Index n_samples, double sample_rate_hz);

/// Welch's estimate of a signal that comes in parts, in memory of one segment: segments with 50 %
/// overlap, each less its mean as the window weighs it, periodic Hann window, density scaling,
///   S(f_k) = 2 / (f_s sum w^2) mean |sum_i w_i x_i e^{-2 pi j i k / n}|^2  (no 2 at 0 and f_s /
///   2).
/// Source: P. D. Welch, IEEE Trans. Audio Electroacoustics 15 (1967); the scaling is that of
/// scipy.signal.welch, whose plain mean leaves a slow floor's lowest two bins five decades too
/// high. Set-up.
class RunningWelch {
 public:
  /// segment_length: samples. Errors: std::invalid_argument for a segment shorter than 2 or a rate
  /// that is not positive.
  RunningWelch(double sample_rate_hz, Eigen::Index segment_length);
  ~RunningWelch();
  RunningWelch(RunningWelch&&) noexcept;
  RunningWelch& operator=(RunningWelch&&) noexcept;

  /// The next samples, any unit.
  void add(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// Samples are missing here: no segment reaches over it.
  void interrupt();
  Eigen::Index n_segments() const { return n_segments_; }

  /// The estimate so far. Before there is a whole segment, that of the longest stretch as one
  /// shorter segment (of a thousand samples and more, its first ones, as many as transforms are
  /// quick for), if it has 2 samples, else an empty density.
  Psd finish() const;

 private:
  struct Transform;
  void take(const Eigen::Ref<const Eigen::VectorXd>& piece, Transform& transform,
            Eigen::VectorXd& power) const;

  double sample_rate_hz_;
  Eigen::Index length_;                   ///< of a segment
  std::unique_ptr<Transform> transform_;  ///< none before the first
  Eigen::VectorXd segment_, power_;       ///< grow to what is there
  Eigen::VectorXd longest_;               ///< stretch before the first whole segment
  Eigen::Index filled_ = 0, n_segments_ = 0;
};

/// The same of a whole signal x. Errors: std::invalid_argument for a segment shorter than 2 or
/// longer than x, or a rate that is not positive.
Psd welch(const Eigen::VectorXd& x, double sample_rate_hz, Eigen::Index segment_length);

/// S_v = S_a / (2 pi f)^2, zero at f = 0.
Psd velocity_from_acceleration(const Psd& acceleration);

/// Root of the integral of the density from lower_hz to upper_hz; bins that the edges cut count in
/// part.
double band_rms(const Psd& psd, double lower_hz, double upper_hz);

/// The integrals of the density between neighbours of edges_hz (ascending), bins that an edge cuts
/// shared between its sides: the squares of band_rms, all at once.
Eigen::VectorXd band_powers(const Psd& psd, const Eigen::VectorXd& edges_hz);

/// How much of band_rms may be no motion in the band but what the jumps of the record leave there:
/// a step of height A in T seconds has the one-sided density 2 / T (A / (2 pi f))^2.
double jumps_in_band(const Psd& psd, double lower_hz, double upper_hz);

/// How far the power in a band, the square of band_rms, may be wrong either way by what lies beside
/// it, as a root in the signal's unit: a tone is spread over the window's lobes, and where a record
/// breaks off at a height also by 1 / distance. What lies far below the band is left to
/// jumps_in_band. Zero of a Psd that is not RunningPower's.
double leak_in_band(const Psd& psd, double lower_hz, double upper_hz);

/// Hz, of the narrowest band that holds the lobes of a tone in it: the six bins of
/// hann_squared().
double narrowest_band_hz(const Psd& psd);

/// Root of the integral of the density from 0 to each frequency of the PSD, its bin counted whole.
Eigen::VectorXd cumulative_rms(const Psd& psd);

/// A one-third-octave band with base-10 frequencies. Source: IEC 61260-1.
struct OctaveBand {
  double nominal_hz = 0;  ///< as printed on instruments: 1, 1.25, 1.6, 2, ...
  double centre_hz = 0;   ///< 10^(n / 10)
  double lower_hz = 0;    ///< centre 10^(-1/20)
  double upper_hz = 0;    ///< centre 10^(+1/20)
};

/// The twenty bands from 1 to 80 Hz.
std::vector<OctaveBand> third_octave_bands();

/// Rms velocity in each of third_octave_bands(), m/s, from the PSD of an acceleration in m/s^2; NaN
/// of a band that reaches beyond half the sample rate: it was not observed.
Eigen::VectorXd third_octave_velocity(const Psd& acceleration);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "report/spectra/spectra.hpp"

namespace stillframe::report {

/// How the power of a signal that comes in parts is spread over frequency, every sample weighing
/// the same. (Welch's segments weigh the ends of a record less: that is an estimate of a stationary
/// density and not of what one record held.) The signal, zero before its beginning, behind its end
/// and where samples are missing, less the mean of its first window, is cut by windows w =
/// hann_squared(n) a fifth of their length apart, whose squares add up to 175/128 everywhere:
///   S(f_k) = 2 / (f_s 175/128 N) sum over windows |sum_i w_i x_i e^{-2 pi j i k / n}|^2,
/// whose integral is the mean square of the N samples to rounding (Parseval), and that over a band
/// the mean square of the band but for leak_in_band and jumps_in_band.
///
/// A window is as long as the record, and no longer than resolves the lowest frequency that is
/// asked of, 200 periods of it: an edge there is known to three bins, 1.5 %. Of a shorter record
/// than 24 periods it holds zeros beside, so that edges are known to an eighth of that frequency
/// then, too, and what the ends do is told by jumps. Nor is it longer than 2^20 samples, which
/// bounds the memory: 12 MB beside 50 MB while a transform is taken. Set-up.
class RunningPower {
 public:
  /// lowest_hz: of the edges of bands; expected: samples, 0: not known. Errors:
  /// std::invalid_argument for a rate or a frequency that is not positive.
  explicit RunningPower(double sample_rate_hz, double lowest_hz = 1, std::int64_t expected = 0);
  ~RunningPower();
  RunningPower(RunningPower&&) noexcept;
  RunningPower& operator=(RunningPower&&) noexcept;

  /// The next samples, any unit.
  void add(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// The next n samples are missing.
  void skip(std::int64_t n);
  /// The power so far; an empty density before there are 2 samples.
  Psd finish() const;

 private:
  class Windows;
  double sample_rate_hz_;
  Eigen::Index shortest_, n_;  ///< samples in a window, n_ a multiple of 10
  Eigen::Index beside_;        ///< samples beside an end, two periods of the lowest frequency
  std::vector<double> first_;
  std::unique_ptr<Windows> windows_;  ///< none while the first samples are waited for
};

/// The same of a whole signal.
Psd power_of(const Eigen::VectorXd& x, double sample_rate_hz, double lowest_hz = 1);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "report/analysis/level_track.hpp"
#include "report/page/envelope.hpp"
#include "report/spectra/running_power.hpp"
#include "report/spectra/spectra.hpp"

namespace stillframe::report {

/// What one acceleration did over a run. Unit m/s^2.
struct SignalAnalysis {
  double rms = 0;                 ///< of the samples, mean included
  double peak = 0;                ///< largest magnitude of a sample
  Psd density;                    ///< Welch, (m/s^2)^2 / Hz; empty for a run without two samples
  Psd power;                      ///< RunningPower, what levels are of; empty with the density
  Eigen::VectorXd third_octaves;  ///< m/s rms in third_octave_bands(), empty with the density
  page::Envelope envelope;
  std::vector<double> levels;  ///< rms in tenths of a second, LevelTrack
};

/// Takes one acceleration sample by sample. Set-up.
class SignalAnalyser {
 public:
  /// first_time_s: s of plant time, of the first sample. lowest_hz, expected: as RunningPower.
  explicit SignalAnalyser(double sample_rate_hz, double first_time_s = 0, double lowest_hz = 1,
                          std::int64_t expected = 0);
  void add(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// The next n samples are missing.
  void skip(std::int64_t n);
  /// As these, of samples that are in the envelope only: before or behind all others.
  void show(const Eigen::Ref<const Eigen::VectorXd>& x) { envelope_.add(x); }
  void skip_shown(std::int64_t n) { envelope_.skip(n); }
  SignalAnalysis finish() const;

 private:
  RunningWelch density_;
  RunningPower power_;
  page::EnvelopeBuilder envelope_;
  LevelTrack levels_;
  double sum_ = 0, peak_ = 0;
  std::int64_t count_ = 0;
};

/// The same of a whole signal.
SignalAnalysis analyse_signal(const Eigen::VectorXd& x, double sample_rate_hz);

/// What the actuator of one leg did, as SignalAnalysis.
struct LegAnalysis {
  std::string name;
  double applied_rms = 0, applied_peak = 0;  ///< N, what acted
  double command_peak = 0;                   ///< N, what was asked for
  double sigma_rms = 0, sigma_peak = 0;      ///< N, what the force sensor read
  page::Envelope applied;                    ///< N
};

/// Takes one leg. Set-up.
class LegAnalyser {
 public:
  LegAnalyser(std::string name, double sample_rate_hz, double first_time_s = 0);
  /// n samples each; a command of NaN is none.
  void add(const Eigen::Ref<const Eigen::VectorXd>& applied,
           const Eigen::Ref<const Eigen::VectorXd>& sigma,
           const Eigen::Ref<const Eigen::VectorXd>& command);
  void skip(std::int64_t n);
  /// In the envelope only.
  void show(const Eigen::Ref<const Eigen::VectorXd>& applied) { envelope_.add(applied); }
  LegAnalysis finish() const;

 private:
  LegAnalysis result_;
  page::EnvelopeBuilder envelope_;
  double applied_sum_ = 0, sigma_sum_ = 0;
  std::int64_t count_ = 0;
};

}  // namespace stillframe::report

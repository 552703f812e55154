#include <gtest/gtest.h>

#include <numbers>

#include "report/analysis/signal_analyser.hpp"
#include "report/analysis/summaries.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd sine(double amplitude, double frequency_hz, Index n) {
  const double omega = 2 * std::numbers::pi * frequency_hz;
  return VectorXd::NullaryExpr(
      n, [=](Index k) { return amplitude * std::sin(omega * 1e-3 * static_cast<double>(k)); });
}

TEST(SignalAnalyser, LevelOfASine) {
  // 2 mm/s^2 at 20 Hz (centre 19.95 Hz) for 64 s.
  const double amplitude = 2e-3, omega = 2 * std::numbers::pi * 20;
  const SignalAnalysis signal = analyse_signal(sine(amplitude, 20, 64000), 1000);
  const MotionLevel level = motion_level(signal);
  // 64 s of it, cut off at both ends: 1e-4 of its power lies where it broke off and not at 20 Hz.
  EXPECT_NEAR(level.rms_acceleration, amplitude / std::sqrt(2.0), 1e-4 * amplitude);
  EXPECT_NEAR(level.largest_band_velocity, amplitude / omega / std::sqrt(2.0),
              1e-3 * amplitude / omega);
  EXPECT_EQ(level.largest_band_hz, 20);
  // 11.25 um/s.
  EXPECT_EQ(level.vibration_class, "VC-C");
  // 50 samples a period, of which no one need be the crest: cos(pi / 50).
  EXPECT_NEAR(level.peak_acceleration, amplitude, 0.002 * amplitude);
  EXPECT_NEAR(signal.rms, amplitude / std::sqrt(2.0), 1e-15);
  const MotionSpectra spectra = motion_spectra(signal);
  // Next to nothing below the band of 20 Hz, all of it from there on.
  EXPECT_LT(spectra.cumulative_rms[12], 0.02 * amplitude);
  EXPECT_NEAR(spectra.cumulative_rms[13], amplitude / std::sqrt(2.0), 1e-3 * amplitude);
}

TEST(SignalAnalyser, PartsAreTheWholeAndGapsAreNotBridged) {
  const VectorXd x = sine(1e-3, 7, 50000) + sine(3e-3, 31, 50000);
  const SignalAnalysis whole = analyse_signal(x, 1000);
  SignalAnalyser parts(1000);
  for (Index begin = 0, n = 1; begin < x.size();
       begin += n, n = std::min(2 * n, x.size() - begin)) {
    parts.add(x.segment(begin, n));
  }
  EXPECT_EQ(parts.finish().density.density, whole.density.density);
  EXPECT_EQ(parts.finish().peak, whole.peak);

  // Two stretches of one segment each, a gap between them: the mean of their spectra.
  SignalAnalyser gapped(1000);
  gapped.add(x.head(16000));
  gapped.skip(777);
  gapped.add(x.segment(20000, 16000));
  const VectorXd mean = 0.5 * (welch(x.head(16000), 1000, 16000).density +
                               welch(x.segment(20000, 16000), 1000, 16000).density);
  EXPECT_LT((gapped.finish().density.density - mean).norm(), 1e-14 * mean.norm());
  EXPECT_EQ(gapped.finish().envelope.n_samples, 32777);
}

TEST(SignalAnalyser, AShortRunIsOneSegment) {
  const VectorXd x = sine(1e-3, 7, 3000);
  const SignalAnalysis signal = analyse_signal(x, 1000);
  EXPECT_EQ(signal.density.density, welch(x, 1000, 3000).density);
  EXPECT_EQ(analyse_signal(VectorXd::Ones(1), 1000).third_octaves.size(), 0);
  EXPECT_EQ(motion_level(analyse_signal(VectorXd(), 1000)).vibration_class, "");
  // The longest stretch stands for a run of short ones.
  SignalAnalyser pieces(1000);
  pieces.add(x.head(500));
  pieces.skip(1);
  pieces.add(x.head(2000));
  pieces.skip(1);
  pieces.add(x.head(100));
  EXPECT_EQ(pieces.finish().density.density, welch(x.head(2000), 1000, 2000).density);
}

TEST(SignalAnalyser, LevelsAreOfTheWholeRecord) {
  // Ten times as loud in its first 8 s of 64: Welch's segments have half of them.
  VectorXd x = sine(1e-3, 7, 64000);
  x.head(8000) *= 10;
  const SignalAnalysis signal = analyse_signal(x, 1000);
  const double exact = 1e-3 * std::sqrt((8 * 100 + 56) / 64.0 / 2);
  // It stops being loud within one sample of 1000, and 1e-3 of its power lies beyond 80 Hz.
  EXPECT_NEAR(motion_level(signal).rms_acceleration, exact, 1e-3 * exact);
  EXPECT_LT(band_rms(signal.density, 1, 80), 0.9 * exact);
}

TEST(SignalAnalyser, HistoriesAreOnPlantTime) {
  SignalAnalyser signal(1000, 12.5);
  signal.add(sine(1, 7, 100));
  EXPECT_EQ(signal.finish().envelope.first_time_s, 12.5);
}

TEST(LegAnalyser, MeasuresWhatActedAndWhatWasAskedFor) {
  LegAnalyser leg("leg", 1000);
  const VectorXd applied = VectorXd::LinSpaced(4, -1, 2), sigma = VectorXd::Constant(4, 3);
  VectorXd command = VectorXd::Constant(4, std::nan(""));
  command(2) = -7;
  leg.add(applied, sigma, command);
  const LegAnalysis result = leg.finish();
  EXPECT_EQ(result.name, "leg");
  EXPECT_EQ(result.applied_peak, 2);
  EXPECT_NEAR(result.applied_rms, std::sqrt(6.0 / 4), 1e-15);
  EXPECT_EQ(result.command_peak, 7);
  EXPECT_EQ(result.sigma_rms, 3);
}

}  // namespace
}  // namespace stillframe::report

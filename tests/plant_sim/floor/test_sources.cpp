#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include "core/numerics/worst.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/high_pass.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "plant_sim/floor/resample.hpp"
#include "plant_sim/floor/sources.hpp"
#include "tests/plant_sim/floor/spectrum.hpp"
#include "tests/support/allocation_count.hpp"

namespace stillframe::floor {
namespace {

const std::string floors = STILLFRAME_SOURCE_DIR "/config/floors/";

std::unique_ptr<FloorSource> shipped(const std::string& name, double rate) {
  return make_floor_source(read_floor_block(YamlReader::from_file(floors + name), rate, 6));
}

std::unique_ptr<FloorSource> from(const std::string& text, double rate, Eigen::Index inputs) {
  return make_floor_source(
      read_floor_block(YamlReader::from_text(text, "floor.yaml"), rate, inputs));
}

Eigen::MatrixXd all_samples(const FloorSource& source) {
  Eigen::MatrixXd w(source.channels(), source.n_samples());
  for (Eigen::Index k = 0; k < w.cols(); ++k) source.sample(k, w.col(k));
  return w;
}

/// Largest |position| of each channel when the held acceleration is integrated twice from rest.
Eigen::VectorXd largest_position(const Eigen::MatrixXd& acceleration, double rate) {
  const double ts = 1.0 / rate;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(acceleration.rows()), v = x, largest = x;
  for (Eigen::Index k = 0; k < acceleration.cols(); ++k) {
    x += ts * v + 0.5 * ts * ts * acceleration.col(k);
    v += ts * acceleration.col(k);
    largest = largest.cwiseMax(x.cwiseAbs());
  }
  return largest;
}

/// The largest position per unit of acceleration ahead of the high-pass: the sum of |impulse
/// response| of the high-pass with a double integrator behind it, no input of modulus 1 can do
/// worse.
double position_bound(double corner, double rate) {
  HighPass filter(corner, rate);
  const double ts = 1.0 / rate;
  double x = 0.0, v = 0.0, sum = 0.0;
  for (int k = 0; k < static_cast<int>(30.0 * rate); ++k) {  // poles down to exp(-36)
    const double a = filter.step(k == 0 ? 1.0 : 0.0);
    x += ts * v + 0.5 * ts * ts * a;
    v += ts * a;
    sum += std::abs(x);
  }
  return sum;
}

TEST(RecordedFloor, PositionStaysBoundedAndWouldNotWithoutTheHighPass) {
  const double rate = 1000.0;
  for (const auto& [yaml, csv, scale] : {std::tuple{"vc_d.yaml", "mikb_floor_200hz.csv", 8.9},
                                         std::tuple{"quake.yaml", "mikb_quake_200hz.csv", 1.0}}) {
    Eigen::MatrixXd raw = scale * read_recording(floors + csv).acceleration;
    taper_ends(raw, 200);
    raw = resample(raw, Ratio{5, 1});
    const double bound = position_bound(0.5, rate) * worst_of(raw);
    const auto source = shipped(yaml, rate);
    ASSERT_EQ(source->n_samples(), 390001);
    const Eigen::MatrixXd filtered = all_samples(*source);
    EXPECT_LT(worst_of(largest_position(filtered, rate)), bound) << yaml;
    EXPECT_GT(largest_position(raw, rate).minCoeff<Eigen::PropagateNaN>(), bound) << yaml;

    // Above ten times the corner the filter does nothing but turn the phase: the fourth-order
    // roll-off leaves 1 - 10^-8 / 2 of the gain, the rest is the leakage of large low lines, -92
    // dB.
    for (const double f : {5.0, 17.3, 29.85, 59.5}) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        const double before = std::abs(testing::line(raw.row(i), f, rate));
        const double after = std::abs(testing::line(filtered.row(i), f, rate));
        EXPECT_NEAR(after, before, 0.02 * before) << yaml << " " << f << " Hz";
      }
    }
  }
}

TEST(RecordedFloor, StartAndAxesSelectWhatIsPlayed) {
  const std::string head =
      "recording: {file: '" + floors + "mikb_quake_200hz.csv', high_pass_hz: 0.5, ";
  const auto plain = all_samples(*from(head + "axes: {ax_E: x, ay_N: y, az_Up: z}}", 200.0, 6));
  const auto turned = all_samples(*from(head + "scale: 2, axes: {ax_E: z, az_Up: x}}", 200.0, 1));
  ASSERT_EQ(plain.cols(), 78001);
  EXPECT_EQ(turned.row(0), 2.0 * plain.row(2));  // doubling is exact in binary
  EXPECT_TRUE((turned.row(1).array() == 0.0).all());
  EXPECT_EQ(turned.row(2), 2.0 * plain.row(0));
  const auto late =
      all_samples(*from(head + "start_s: 60, axes: {ax_E: x, ay_N: y, az_Up: z}}", 200.0, 6));
  ASSERT_EQ(late.cols(), 78001 - 12000);
  // The two differ by the taper's and the filter's beginning, which the filter forgets as exp(-1.2
  // t): after 40 s only rounding is left.
  const Eigen::Index n = late.cols() - 8000;
  EXPECT_LT(worst_of(late.rightCols(n) - plain.rightCols(n)), 1e-14);
}

TEST(Sources, TheSameBlockGivesTheSameBits) {
  for (const char* name :
       {"vc_d.yaml", "quake.yaml", "multisine.yaml", "vc_d_noise.yaml", "workshop.yaml"}) {
    EXPECT_EQ(all_samples(*shipped(name, 1000.0)), all_samples(*shipped(name, 1000.0))) << name;
  }
  const std::string white = "white: {rms: 1, duration_s: 2, seed: 7}";
  EXPECT_EQ(all_samples(*from(white, 1000.0, 3)), all_samples(*from(white, 1000.0, 3)));
}

TEST(Sources, SamplesMayBeAskedForInAnyOrderAndOutsideNothingMoves) {
  const auto source = from("white: {rms: 1, duration_s: 0.1}", 1000.0, 2);
  ASSERT_EQ(source->n_samples(), 100);
  Eigen::VectorXd late(2), again(2), early(2), outside = Eigen::VectorXd::Ones(2);
  source->sample(99, late);
  source->sample(0, early);
  source->sample(99, again);
  EXPECT_EQ(late, again);
  EXPECT_NE(late, early);
  source->sample(100, outside);
  EXPECT_TRUE(outside.isZero(0.0));
  outside.setOnes();
  source->sample(-1, outside);
  EXPECT_TRUE(outside.isZero(0.0));
}

TEST(Sources, SamplingAllocatesNothing) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(6), w(6);
  for (const char* text : {"white: {rms: 1, duration_s: 1}", "still: {duration_s: 1}",
                           "multisine: {frequencies_hz: [1], amplitude: 1}"}) {
    const auto source = from(text, 1000.0, 6);
    const std::int64_t before = test::allocation_count();
    for (std::int64_t k = -1; k < 1001; ++k) {
      source->sample(k, w);
      sum += w;
    }
    EXPECT_EQ(test::allocation_count(), before) << text;
  }
  const std::int64_t before = test::allocation_count();
  const Eigen::VectorXd copy = sum;
  EXPECT_GT(test::allocation_count(), before) << copy(0);  // the counter does count
}

TEST(Sources, StillMeansStill) {
  const auto source = from("still: {duration_s: 2.5}", 1000.0, 4);
  EXPECT_EQ(source->meaning(), FloorChannels::inputs);
  EXPECT_EQ(source->channels(), 4);
  EXPECT_EQ(source->n_samples(), 2500);
  EXPECT_TRUE(all_samples(*source).isZero(0.0));
}

TEST(WhiteFloor, IsGaussianIndependentAndOfTheRmsAsked) {
  const Eigen::Index n = 200000;
  const auto source = from("white: {rms: 0.3, duration_s: 200, high_pass_hz: 20}", 1000.0, 3);
  const Eigen::MatrixXd w = all_samples(*source);
  ASSERT_EQ(w.cols(), n);
  const Eigen::MatrixXd covariance = w * w.transpose() / static_cast<double>(n);
  // A variance from n Gaussian samples scatters by sqrt(2 / n) = 0.32 %, a covariance by sqrt(1 /
  // n) = 0.22 %, slightly more with the colour of the filter; five standard deviations.
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(covariance(i, i), 0.09, 0.09 * 0.016);
    for (Eigen::Index j = 0; j < i; ++j) EXPECT_NEAR(covariance(i, j), 0.0, 0.09 * 0.011);
    // Fourth moment 3 sigma^4, scatter sqrt(96 / n) sigma^4 = 0.022 sigma^4.
    const double kurtosis = w.row(i).array().pow(4).mean() / std::pow(covariance(i, i), 2);
    EXPECT_NEAR(kurtosis, 3.0, 0.11);
  }
  const auto other =
      from("white: {rms: 0.3, duration_s: 200, high_pass_hz: 20, seed: 2}", 1000.0, 3);
  const Eigen::MatrixXd v = all_samples(*other);
  EXPECT_NEAR(w.row(0).dot(v.row(0)) / static_cast<double>(n), 0.0, 0.09 * 0.011);
}

}  // namespace
}  // namespace stillframe::floor

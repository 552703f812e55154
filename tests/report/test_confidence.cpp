#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "report/identification/confidence.hpp"
#include "report/identification/local_polynomial.hpp"
#include "report/identification/multisine.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// How often bands held.
struct Tally {
  double n = 0, held = 0;
  void add(bool holds) {
    ++n;
    if (holds) ++held;
  }
  double share() const { return held / n; }
};

struct Coverage {
  Tally entries, magnitudes, singular_values, coherent;

  void add(const FrequencyResponse& response, const SampledLoop& loop) {
    const Bands bands = singular_value_bands(response, 0.95, 400);
    for (Index l = 0; l < response.n_frequencies(); ++l) {
      const double frequency = response.frequencies_hz[static_cast<std::size_t>(l)];
      const MatrixXcd exact = transfer(loop, 2 * toy::pi * frequency);
      const MatrixXd distance = (response.T[static_cast<std::size_t>(l)] - exact).cwiseAbs();
      const MatrixXd radii = entry_radii(response, l, 0.95);
      for (Index i = 0; i < exact.rows(); ++i) {
        const Interval band = magnitude_band(response, l, i, i, 0.95);
        magnitudes.add(band.lower <= std::abs(exact(i, i)) && std::abs(exact(i, i)) <= band.upper);
      }
      for (Index i = 0; i < distance.size(); ++i) {
        entries.add(distance.reshaped()(i) <= radii.reshaped()(i));
      }
      const MatrixXd sigma = report::singular_values(std::vector<MatrixXcd>{exact});
      for (Index i = 0; i < sigma.cols(); ++i) {
        const bool holds = bands.lower(l, i) <= sigma(i) && sigma(i) <= bands.upper(l, i);
        singular_values.add(holds);
        if (response.directional_coherence(l, i) > 0.99) coherent.add(holds);
      }
    }
  }
};

/// A run with noise of the force sensors, N, and of the readings of the frame, m/s^2.
toy::Record noisy_run(const SampledLoop& loop, const MatrixXd& w, double sensor, double reading,
                      std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](Index n, double rms) -> VectorXd {
    return rms * VectorXd::NullaryExpr(n, [&] { return normal(random); });
  };
  toy::Record record{MatrixXd::Zero(w.rows() + 1, w.cols()),
                     MatrixXd::Zero(w.rows() + 1, loop.C.rows())};
  VectorXd state = VectorXd::Zero(loop.A.rows());
  for (Index k = 0; k < w.rows(); ++k) {
    const VectorXd input = w.row(k).transpose(), v = noise(loop.B_v.cols(), sensor);
    record.inputs.row(k + 1) = input.transpose();
    record.outputs.row(k + 1) =
        (loop.C * state + loop.D * input + loop.D_v * v + noise(loop.C.rows(), reading))
            .transpose();
    state = loop.A * state + loop.B * input + loop.B_v * v;
  }
  return record;
}

SampledLoop closed_loop_of(const toy::Frame& frame, double sample_time) {
  const SampledPlant plant = sample_and_hold(frame.plant(), toy::sampled_at(sample_time, 1));
  return close_loop(plant, frame.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, sample_time));
}

constexpr int n_runs = 200;

Coverage multisine_coverage(const toy::Frame& frame, double sensor) {
  const MultisinePlan plan = toy::plan();
  const SampledLoop loop = closed_loop_of(frame, 1 / plan.sample_rate_hz);
  constexpr double amplitude = 1e-3;
  const MatrixXd w = toy::multisine(plan, amplitude);
  Coverage coverage;
  for (int run = 0; run < n_runs; ++run) {
    const auto record =
        noisy_run(loop, w, sensor, 0.1 * amplitude, 100 + static_cast<unsigned>(run));
    coverage.add(identify(plan, record.inputs, record.outputs), loop);
  }
  return coverage;
}

// 95 % bands are to hold 93 to 97 % of the time. 200 runs of 17 frequencies with 9 entries, of
// which those of a row share their noise estimate: at least 200 x 17 x 3 independent trials, whose
// share scatters by 0.2 %. Bands of singular values are made to hold more often where they can be
// told neither from one another nor from zero, as those of incoherent directions.
void expect_held(const Coverage& coverage) {
  std::cout << "held: entries " << coverage.entries.share() << " of " << coverage.entries.n
            << ", magnitudes " << coverage.magnitudes.share() << " of " << coverage.magnitudes.n
            << ", singular values " << coverage.singular_values.share() << " of "
            << coverage.singular_values.n << ", those of coherence above 0.99 "
            << coverage.coherent.share() << " of " << coverage.coherent.n << "\n";
  EXPECT_GE(coverage.entries.share(), 0.93);
  EXPECT_LE(coverage.entries.share(), 0.97);
  EXPECT_GE(coverage.magnitudes.share(), 0.93);
  EXPECT_LE(coverage.magnitudes.share(), 0.97);
  EXPECT_GE(coverage.singular_values.share(), 0.93);
  EXPECT_GT(coverage.coherent.n, 1000);
  EXPECT_GE(coverage.coherent.share(), 0.93);
  EXPECT_LE(coverage.coherent.share(), 0.97);
}

TEST(Confidence, BandsOfAMultisineHold) { expect_held(multisine_coverage({}, 1e-3)); }

TEST(Confidence, BandsHoldWhereSingularValuesCoincide) {
  toy::Frame frame;
  frame.modes_hz = {13.9055, 13.9055, 31.3203};
  expect_held(multisine_coverage(frame, 1e-3));
}

TEST(Confidence, BandsOfBroadbandNoiseHold) {
  const toy::Frame frame;
  constexpr double rate = 500, amplitude = 1e-3;
  const SampledLoop loop = closed_loop_of(frame, 1 / rate);
  const BroadbandPlan plan{.sample_rate_hz = rate,
                           .n_inputs = 3,
                           .n_outputs = 3,
                           .frequencies_hz = {1, 2, 4, 7, 10, 16, 22, 34, 50, 80, 120},
                           .segment_s = 16,
                           .expected_s = 32};
  Coverage coverage;
  std::mt19937_64 random(17);
  std::normal_distribution<double> normal;
  for (int run = 0; run < n_runs; ++run) {
    const MatrixXd w = amplitude * MatrixXd::NullaryExpr(16000, 3, [&] { return normal(random); });
    const auto record =
        noisy_run(loop, w, 1e-4, 0.02 * amplitude, 500 + static_cast<unsigned>(run));
    LocalPolynomial estimator(plan);
    estimator.add(0, record.inputs, record.outputs);
    estimator.finish();
    coverage.add(estimator.estimate(), loop);
  }
  expect_held(coverage);
}

TEST(Confidence, StudentsQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(student_quantile(0.95, 10), 2.228139, 1e-6);
  EXPECT_NEAR(student_quantile(0.95, 1e9), 1.959964, 1e-6);
}

TEST(Confidence, RadiiOfKnownNoiseAreThoseOfRayleigh) {
  // With the noise level known, |dT|^2 / (C G) is exponential: the quantile is -ln(0.05).
  FrequencyResponse response;
  response.frequencies_hz = {1};
  response.T = {MatrixXcd::Zero(2, 1)};
  response.noise = {Eigen::Vector2cd(4, 9).asDiagonal().toDenseMatrix()};
  response.input_weight = {MatrixXcd::Constant(1, 1, 0.25)};
  response.dof = VectorXd::Constant(1, 1e12);
  const MatrixXd radii = entry_radii(response, 0, 0.95);
  EXPECT_NEAR(radii(0, 0), std::sqrt(-std::log(0.05) * 4 * 0.25), 1e-9);
  EXPECT_NEAR(radii(1, 0), std::sqrt(-std::log(0.05) * 9 * 0.25), 1e-9);
}

/// Magnitudes from none to far above the noise, with few degrees of freedom and with many.
TEST(Confidence, BandsOfAMagnitudeHoldWhereverItIs) {
  std::mt19937_64 random(23);
  std::normal_distribution<double> normal(0, std::sqrt(0.5));
  FrequencyResponse response;
  response.frequencies_hz = {1};
  response.input_weight = {MatrixXcd::Identity(1, 1)};
  constexpr int n = 20000;
  for (const double dof : {4.0, 12.0, 200.0}) {
    response.dof = VectorXd::Constant(1, dof);
    std::gamma_distribution<double> level(dof, 1 / dof);
    for (const double exact : {0.0, 0.3, 1.0, 1.5, 2.0, 3.0, 10.0, 1e6}) {
      Tally held;
      for (int i = 0; i < n; ++i) {
        const double re = exact + normal(random), im = normal(random);
        response.T = {MatrixXcd::Constant(1, 1, {re, im})};
        response.noise = {MatrixXcd::Constant(1, 1, level(random))};
        const Interval band = magnitude_band(response, 0, 0, 0, 0.95);
        held.add(band.lower <= exact && exact <= band.upper);
        EXPECT_LE(band.lower, std::hypot(re, im));
        EXPECT_GE(band.upper, std::hypot(re, im));
      }
      // 93.5 to 97.2 %, a share of n scatters by 0.15 %: four times that.
      EXPECT_GE(held.share(), 0.929) << dof << " " << exact;
      EXPECT_LE(held.share(), 0.978) << dof << " " << exact;
      if (exact >= 3) {
        EXPECT_NEAR(held.share(), 0.95, 0.006) << dof << " " << exact;
      }
    }
  }
  response.T = {MatrixXcd::Constant(1, 1, std::nan(""))};
  response.dof.setZero();
  EXPECT_TRUE(std::isnan(magnitude_band(response, 0, 0, 0, 0.95).upper));
}

TEST(Confidence, SingleValuesHaveStudentsBands) {
  // One singular value far above the noise is a real number with Gaussian noise of half the power.
  FrequencyResponse response;
  response.frequencies_hz = {1};
  response.T = {MatrixXcd::Constant(1, 1, {3, 4})};
  response.noise = {MatrixXcd::Constant(1, 1, 1e-6)};
  response.input_weight = {MatrixXcd::Identity(1, 1)};
  response.dof = VectorXd::Constant(1, 8);
  response.singular_values = singular_values(response.T);
  const Bands bands = singular_value_bands(response, 0.95, 40000);
  const double half = student_quantile(0.95, 16) * std::sqrt(0.5e-6);
  // A 2.5 % quantile of 40000 draws is known to 1 / sqrt(40000 * 0.025 * 0.975) / 0.06 = 1.3 % of
  // the spread of about two; four times that.
  EXPECT_NEAR((bands.upper(0, 0) - 5) / half, 1, 0.05);
  EXPECT_NEAR((5 - bands.lower(0, 0)) / half, 1, 0.05);
}

}  // namespace
}  // namespace stillframe::report

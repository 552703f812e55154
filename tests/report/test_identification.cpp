#include <gtest/gtest.h>

#include "core/errors/input_error.hpp"
#include "core/numerics/worst.hpp"
#include "report/identification/multisine.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double amplitude = 1e-3;

double largest_error(const FrequencyResponse& response, const SampledLoop& loop) {
  double largest = 0;
  for (std::size_t l = 0; l < response.T.size(); ++l) {
    const MatrixXcd exact = transfer(loop, 2 * toy::pi * response.frequencies_hz[l]);
    largest = worst_of(largest, (response.T[l] - exact).norm() / exact.norm());
  }
  return largest;
}

class Identification : public ::testing::Test {
 protected:
  MultisinePlan plan_ = toy::plan();
  toy::Frame frame_;
  SampledPlant plant_ =
      sample_and_hold(frame_.plant(), toy::sampled_at(1 / plan_.sample_rate_hz, 1));
  SampledLoop open_ = open_loop(plant_);
  SampledLoop closed_ =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, plant_.sample_time));
};

// The same transfer function by hand, turned into leg directions: one mode under a held input w has
// the relative velocity V(z) = -(sin omega T_s / omega) (z - 1) / (z^2 - 2 z cos omega T_s + 1)
// W(z), and the mean acceleration over a sample is (z - 1) V / T_s + W.
MatrixXcd closed_form(const toy::Frame& frame, double frequency_hz, double sample_time) {
  const std::complex<double> z = std::polar(1.0, 2 * toy::pi * frequency_hz * sample_time);
  Eigen::Vector3cd modal;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * toy::pi * frame.modes_hz[static_cast<std::size_t>(i)] * sample_time;
    modal(i) = 1.0 - std::sin(angle) / angle * (z - 1.0) * (z - 1.0) /
                         (z * z - 2.0 * std::cos(angle) * z + 1.0);
  }
  return frame.V * modal.asDiagonal() * frame.V.transpose();
}

TEST_F(Identification, OpenLoopMatchesStateSpaceAndClosedForm) {
  const auto record = toy::simulate(open_, toy::multisine(plan_, amplitude), VectorXd::Zero(6));
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  // What is left is the free motion that a glide of 2 s stirs up, itself below -92 dB of a line
  // (2.5e-5), seen through side lobes of the same depth: 6e-10, of a resonance some 40 times larger
  // than the response.
  EXPECT_LT(largest_error(response, open_), 1e-7);
  for (std::size_t l = 0; l < response.T.size(); ++l) {
    const MatrixXcd exact = closed_form(frame_, plan_.frequencies_hz[l], plant_.sample_time);
    EXPECT_LT((response.T[l] - exact).norm(), 1e-7 * exact.norm())
        << plan_.frequencies_hz[l] << " Hz";
  }
  // The experiments are orthogonal by construction; rounding of the sines is all that is left.
  EXPECT_LT(worst_of((response.input_condition.array() - 1).matrix()), 1e-9);
}

TEST_F(Identification, ClosedLoopMatchesStateSpace) {
  const auto record =
      toy::simulate(closed_, toy::multisine(plan_, amplitude), VectorXd::Zero(closed_.A.rows()));
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  // As in the open loop, the transients of the well-damped loop having died away within the glide.
  EXPECT_LT(largest_error(response, closed_), 1e-7);
}

TEST_F(Identification, FreeMotionOfAnUndampedPlantDoesNoHarm) {
  // Every mode swings freely with 10 times the acceleration of a line of the excitation.
  VectorXd state = VectorXd::Zero(6);
  const MatrixXd K = frame_.stiffness();
  state.head(3) = K.inverse() * (10 * amplitude * frame_.V.rowwise().sum());
  const auto record = toy::simulate(open_, toy::multisine(plan_, amplitude), state);
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  for (std::size_t l = 0; l < response.T.size(); ++l) {
    const MatrixXcd exact = transfer(open_, 2 * toy::pi * plan_.frequencies_hz[l]);
    // Side lobes below -92 dB, 2.5e-5, of three free modes of amplitude 10, in the norm of three
    // channels and the mean of three blocks.
    EXPECT_LT((response.T[l] - exact).norm(), 3 * 10 * 2.5e-5) << plan_.frequencies_hz[l] << " Hz";
  }
}

TEST_F(Identification, NoiseScattersAsItsVarianceSays) {
  auto record = toy::simulate(open_, toy::multisine(plan_, amplitude), VectorXd::Zero(6));
  std::mt19937_64 random(11);
  const double rms = 0.5 * amplitude;
  // Uniform noise of this rms: half width sqrt(3) rms.
  for (double& value : record.outputs.reshaped()) {
    value += rms * std::sqrt(3.0) * (2 * std::ldexp(static_cast<double>(random() >> 11), -53) - 1);
  }
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  // A bin of noise has variance rms^2 sum w^2, a line is amplitude sum w / 2; averaged over three
  // blocks an entry of T scatters by s = 2 rms sqrt(sum w^2) / (amplitude sum w sqrt(3)), with sum
  // w = 0.35875 N and sum w^2 = 0.25796 N for this window.
  const double n = plan_.window_s * plan_.sample_rate_hz;
  const double s = 2 * rms * std::sqrt(0.25796 * n) / (amplitude * 0.35875 * n * std::sqrt(3.0));
  double sum = 0;
  for (std::size_t l = 0; l < response.T.size(); ++l) {
    sum += (response.T[l] - transfer(open_, 2 * toy::pi * plan_.frequencies_hz[l])).squaredNorm();
  }
  const double measured = std::sqrt(sum / (9.0 * static_cast<double>(response.T.size())));
  // 17 x 9 complex entries: the rms of the scatter is known to 1 / sqrt(2 * 153) = 6 %; four times
  // that.
  EXPECT_NEAR(measured / s, 1, 0.23);
}

TEST_F(Identification, CoherenceIsTheShareOfThePowerThatIsNotNoise) {
  auto record = toy::simulate(open_, toy::multisine(plan_, amplitude), VectorXd::Zero(6));
  const FrequencyResponse quiet = identify(plan_, record.inputs, record.outputs);
  // Between the lines is the free motion that the glide stirs up, below 2.5e-5 of a line, of a
  // resonance some 40 times larger than the response, squared.
  EXPECT_GT(quiet.coherence.minCoeff(), 1 - 1e-6);
  EXPECT_GT(quiet.directional_coherence.minCoeff(), 1 - 1e-6);

  std::mt19937_64 random(3);
  for (Eigen::Index k = 0; k < record.outputs.rows(); ++k) {
    record.outputs(k, 1) +=
        amplitude * (2 * std::ldexp(static_cast<double>(random() >> 11), -53) - 1);
  }
  const FrequencyResponse noisy = identify(plan_, record.inputs, record.outputs);
  const double n = plan_.window_s * plan_.sample_rate_hz;
  for (Eigen::Index l = 0; l < noisy.coherence.rows(); ++l) {
    EXPECT_GT(noisy.coherence(l, 0), 1 - 1e-6);
    // A line has amplitude sum w / 2 = 0.179 n times the norm of T's row, a bin of noise has
    // variance sum w^2 / 3 = 0.086 n amplitude^2; the mean over twelve bins scatters by 1 /
    // sqrt(12), five times that.
    const double line = 0.179375 * n * noisy.T[static_cast<std::size_t>(l)].row(1).norm();
    const double lost = 0.25796 / 3 * n / (line * line);
    EXPECT_NEAR((1 - noisy.coherence(l, 1)) / lost, 1, 5 / std::sqrt(12.0)) << l;
  }
}

TEST_F(Identification, NoiseOfTheInputsIsNoNoiseWhereItIsMeasured) {
  // The floor shakes beside the lines as well, and the plant answers to that.
  MatrixXd w = toy::multisine(plan_, amplitude);
  std::mt19937_64 random(5);
  for (double& value : w.reshaped()) {
    value += amplitude * (2 * std::ldexp(static_cast<double>(random() >> 11), -53) - 1);
  }
  const auto record = toy::simulate(closed_, w, VectorXd::Zero(closed_.A.rows()));
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  // A bin of the noise is 0.58 sqrt(0.258 * 2000) / 359 = 4 % of a line. T changes by some 10 %
  // over the 6 bins (1.5 Hz) to the furthest quiet one, and so much of the noise is left: 0.4 %,
  // squared.
  EXPECT_GT(response.coherence.bottomRows(12).minCoeff(), 1 - 1e-3);
}

TEST_F(Identification, LostSamplesAreFilledInFromTheOtherPeriods) {
  const auto record =
      toy::simulate(closed_, toy::multisine(plan_, amplitude), VectorXd::Zero(closed_.A.rows()));
  const FrequencyResponse whole = identify(plan_, record.inputs, record.outputs);
  MatrixXd inputs = record.inputs, outputs = record.outputs;
  // 2 + 4 s at 500 Hz: the steady part of the second block begins at sample 4001.
  const double lost = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Index row : {17, 4001, 4002, 4503, 5500, 8999}) {
    inputs.row(row).setConstant(lost);
    outputs.row(row).setConstant(lost);
  }
  MatrixXd filled_in = inputs, filled_out = outputs;
  EXPECT_EQ(fill_lost_rows(plan_, filled_in, filled_out), 5);
  EXPECT_TRUE(filled_in.allFinite() && filled_out.allFinite());
  const FrequencyResponse filled = identify(plan_, filled_in, filled_out);
  for (std::size_t l = 0; l < whole.T.size(); ++l) {
    // The free motion within a steady part does not repeat itself, 2.5e-5 of a line as above, and
    // five samples of 2000 have it.
    EXPECT_LT((filled.T[l] - whole.T[l]).norm(), 1e-6 * whole.T[l].norm()) << l;
  }
  for (const Eigen::Index row : {4001, 4501, 5001, 5501}) inputs.row(row).setConstant(lost);
  expect_error<InputError>([&] { fill_lost_rows(plan_, inputs, outputs); }, "all four periods");
  inputs.middleRows(4100, 101).setConstant(lost);
  expect_error<InputError>([&] { fill_lost_rows(plan_, inputs, outputs); }, "allowed is one in 20");
}

TEST_F(Identification, ResponseDoesNotDependOnTheSizeOfTheExcitation) {
  const MatrixXd w = toy::multisine(plan_, amplitude);
  const auto small = toy::simulate(open_, w, VectorXd::Zero(6));
  const auto large = toy::simulate(open_, 1024 * w, VectorXd::Zero(6));
  const auto a = identify(plan_, small.inputs, small.outputs),
             b = identify(plan_, large.inputs, large.outputs);
  // A power of two: every operation rounds alike.
  EXPECT_EQ(a.singular_values, b.singular_values);
}

TEST_F(Identification, InputsNeedNotBeOfOneSize) {
  // Then W is no longer symmetric, and its condition is that of the sizes, 2 / 0.5.
  const MatrixXd w = toy::multisine(plan_, amplitude) * Eigen::Vector3d(1, 0.5, 2).asDiagonal();
  const auto record = toy::simulate(open_, w, VectorXd::Zero(6));
  const FrequencyResponse response = identify(plan_, record.inputs, record.outputs);
  // As in the first test, four times the free motion over the weakest input.
  EXPECT_LT(largest_error(response, open_), 4e-7);
  EXPECT_LT(worst_of((response.input_condition.array() - 4).matrix()), 1e-8);
}

TEST_F(Identification, SingularValuesAreThoseOfDiagonalMatrices) {
  MatrixXcd T = MatrixXcd::Zero(2, 3);
  T(0, 1) = {0, 3};
  T(1, 2) = -5;
  const MatrixXd values = singular_values({T});
  ASSERT_EQ(values.cols(), 2);
  EXPECT_NEAR(values(0, 0), 5, 1e-14);
  EXPECT_NEAR(values(0, 1), 3, 1e-14);
}

TEST_F(Identification, RefusesPlansThatCannotBe) {
  const MatrixXd data = MatrixXd::Zero(10000, 3);
  const auto refuse = [&](auto change, const std::string& message) {
    MultisinePlan plan = plan_;
    change(plan);
    expect_error<InputError>([&] { identify(plan, data, data); }, message);
  };
  refuse([](auto& p) { p.frequencies_hz[0] = 1.25; }, "frequencies_hz 1.25");
  refuse([](auto& p) { p.frequencies_hz.back() = 250; }, "Nyquist");
  refuse([](auto& p) { p.frequencies_hz[1] = 1; }, "increase");
  refuse([](auto& p) { p.frequencies_hz.clear(); }, "none given");
  refuse([](auto& p) { p.ramp_s = 2.0001; }, "samples of ramp_s");
  refuse([](auto& p) { p.n_blocks = 2; }, "the data have 3 inputs");
  refuse([](auto& p) { p.ramp_s = 20; }, "the data end at sample 10000, the plan needs 36001");
  refuse([](auto&) {}, "no independent experiments");
}

TEST_F(Identification, RefusesDataThatAreNotFinite) {
  auto record = toy::simulate(open_, toy::multisine(plan_, amplitude), VectorXd::Zero(6));
  record.outputs(5, 1) = std::numeric_limits<double>::quiet_NaN();
  expect_error<InputError>([&] { identify(plan_, record.inputs, record.outputs); }, "not finite");
}

}  // namespace
}  // namespace stillframe::report

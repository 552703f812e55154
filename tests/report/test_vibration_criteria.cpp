#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"
#include "tests/report/expect_error.hpp"

namespace stillframe::report {
namespace {

using Eigen::VectorXd;

TEST(VibrationCriteria, FlatSpectraMeetTheirClass) {
  const char* names[] = {"VC-A", "VC-B", "VC-C", "VC-D", "VC-E", "VC-F", "VC-G"};
  const double limits[] = {50e-6, 25e-6, 12.5e-6, 6.25e-6, 3.12e-6, 1.56e-6, 0.78e-6};
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(vibration_class(VectorXd::Constant(20, limits[i])), names[i]);
    const std::string looser = i == 0 ? "above VC-A" : names[i - 1];
    EXPECT_EQ(vibration_class(VectorXd::Constant(20, limits[i] * 1.001)), looser);
  }
  EXPECT_EQ(vibration_class(VectorXd::Zero(20)), "VC-G");
}

TEST(VibrationCriteria, OneBandDecides) {
  VectorXd velocity = VectorXd::Zero(20);
  velocity(13) = 10e-6;
  EXPECT_EQ(vibration_class(velocity), "VC-C");
}

TEST(VibrationCriteria, ABandThatWasNotObservedMeetsNothing) {
  VectorXd velocity = VectorXd::Zero(20);
  velocity.tail(3).setConstant(std::nan(""));
  EXPECT_EQ(vibration_class(velocity), "not known");
  velocity(10) = 51e-6;
  EXPECT_EQ(vibration_class(velocity), "above VC-A");
  // What no criterion limits need not be known, but VC-C limits all of them.
  velocity = VectorXd::Constant(20, 20e-6);
  velocity(2) = std::nan("");
  EXPECT_EQ(vibration_class(velocity), "VC-B");
  velocity.setConstant(1e-6);
  velocity(2) = std::nan("");
  EXPECT_EQ(vibration_class(velocity), "not known");
}

TEST(VibrationCriteria, AAndBBeginAtFourHertzWithConstantAcceleration) {
  const auto& criteria = vibration_criteria();
  for (const auto& criterion : criteria) {
    const bool relaxed = criterion.name == "VC-A" || criterion.name == "VC-B";
    EXPECT_DOUBLE_EQ(criterion.limit(4), criterion.velocity * (relaxed ? 2 : 1));
    EXPECT_DOUBLE_EQ(criterion.limit(80), criterion.velocity);
    EXPECT_EQ(criterion.applies(3.16), !relaxed);
    EXPECT_EQ(std::isinf(criterion.limit(1)), relaxed);
  }
  // 260 micro-g at 4 to 8 Hz, the figure of the source, which is rounded to two digits.
  EXPECT_NEAR(criteria[0].limit(5) * 2 * std::numbers::pi * 5 / 9.81e-6, 260, 5);
  // Loud below 4 Hz: neither A nor B looks there.
  VectorXd slow = VectorXd::Zero(20);
  slow.head(6).setConstant(1);
  EXPECT_EQ(vibration_class(slow), "VC-B");
  // The band named 8 Hz has its centre at 7.943 Hz and is flat; the one at 6.31 Hz is relaxed.
  VectorXd velocity = VectorXd::Zero(20);
  velocity(9) = 50.1e-6;
  EXPECT_EQ(vibration_class(velocity), "above VC-A");
  velocity(9) = 0;
  velocity(8) = 50e-6 * 8 / third_octave_bands()[8].centre_hz;
  EXPECT_EQ(vibration_class(velocity), "VC-A");
}

TEST(VibrationCriteria, RefusesOtherBands) {
  expect_error<std::invalid_argument>([] { vibration_class(VectorXd::Zero(3)); },
                                      "expected 20 bands, got 3");
}

}  // namespace
}  // namespace stillframe::report

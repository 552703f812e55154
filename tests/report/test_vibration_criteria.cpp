#include <gtest/gtest.h>

#include <cmath>
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
  velocity(13) = std::nan("");
  EXPECT_EQ(vibration_class(velocity), "above VC-A");
}

TEST(VibrationCriteria, OnlyAAndBAreRelaxedBelowEightHertz) {
  const auto& criteria = vibration_criteria();
  for (const auto& criterion : criteria) {
    EXPECT_EQ(criterion.relaxed_below_8_hz, criterion.name == "VC-A" || criterion.name == "VC-B");
    EXPECT_DOUBLE_EQ(criterion.limit(4),
                     criterion.velocity * (criterion.relaxed_below_8_hz ? 2 : 1));
    EXPECT_DOUBLE_EQ(criterion.limit(80), criterion.velocity);
  }
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

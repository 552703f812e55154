#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/numerics/singular_values.hpp"
#include "tests/design_cases/expectations.hpp"

// Actuators with a lag of 300 Hz.
namespace stillframe::test {
namespace {

constexpr double lag_hz = 300;

Scene slow_scene(double rate_hz, double lead, std::optional<double> roll_off_hz = {}) {
  Scene scene = case_scene("frame_slow_actuators", "force_feedback_5hz");
  scene.controller->sample_rate_hz = rate_hz;
  scene.controller->lead_samples = lead;
  scene.controller->roll_off_hz = roll_off_hz;
  return scene;
}

/// The same with the command reported as applied.
Scene commanded(Scene scene) {
  scene.instruments.report = Instruments::Report::commanded;
  return scene;
}

/// Samples that make up for a delay of one, for half a sample of hold, and for the lags.
double lead(double rate_hz, double roll_off_hz = 0) {
  double sum = 1.5 + rate_hz / (2 * std::numbers::pi * lag_hz);
  if (roll_off_hz > 0) sum += rate_hz / (2 * std::numbers::pi * roll_off_hz);
  return sum;
}

TEST(SlowActuators, LagIsADamperToTheFloor) {
  const Case made = make_case(slow_scene(1000, 1.5));
  print_line("lead 1.5", made);
  EXPECT_NEAR(made.predicted_db(10), -3.2, 0.05);  // read off once
  expect_stable_as_predicted(made);
}

TEST(SlowActuators, LeadMakesUpForIt) {
  const Case made = make_case(slow_scene(1000, lead(1000)));
  print_line("lead 2.03", made);
  EXPECT_NEAR(made.predicted_db(10), -13.1, 0.05);  // read off once
  expect_stable_as_predicted(made);
  const Case fast = make_case(slow_scene(5000, lead(5000)));
  print_line("5 kHz, lead 4.15", fast);
  // Of T of the law without sampling or lag, -12.3 dB. What the lead leaves is of second order in
  // omega (lead + 1) T_s = 0.065, 0.4 % of a stiffness that the law has divided by up to 96.
  const Case rigid = make_case(case_scene("metrology_frame"));
  const double continuous = singular_values(rigid.loop.closed({0, 2 * std::numbers::pi * 10}))(0);
  EXPECT_NEAR(fast.predicted_db(10), 20 * std::log10(continuous), 0.5);
}

TEST(SlowActuators, TheScenesOwnController) {
  const Case made = make_case(case_scene("frame_slow_actuators"));
  print_line("force_feedback_lag_300hz.yaml", made);
  EXPECT_NEAR(made.scene.controller->lead_samples, lead(5000, 800), 5e-3);  // three digits
  expect_stable_as_predicted(made);
}

// Reported is the command c, what acts is f = c (1 - a) z / (z - a), a = exp(-omega_a T_s). At half
// the rate, z = -1, the part 2 a / (1 + a) of the command comes back as if the frame had moved, and
// the law answers it 1 + 2 lead times, with gain one else: above one in all the loop is unstable.
TEST(SlowActuators, CommandReportedAsAppliedIsALoopAtHalfTheRate) {
  for (const double rate : {1000.0, 1500.0, 2000.0, 5000.0}) {
    const double a = std::exp(-2 * std::numbers::pi * lag_hz / rate);
    const double limit = ((1 + a) / (2 * a) - 1) / 2;  // of the lead
    // The law's gain at half the rate is short of one by 1 / X, up to 13 % for the softest mode and
    // 1 % for the stiffest, which decides; 5 % of 1 + 2 lead either way is well beyond that.
    const double step = 0.05 * (limit + 0.5);
    EXPECT_TRUE(make_case(commanded(slow_scene(rate, limit - step))).stable()) << rate;
    EXPECT_FALSE(make_case(commanded(slow_scene(rate, limit + step))).stable()) << rate;
  }
}

TEST(SlowActuators, ARollOffForgivesIt) {
  const Case plain = make_case(commanded(slow_scene(1000, 1.5)));
  const Case leading = make_case(commanded(slow_scene(1000, lead(1000))));
  const Case fast = make_case(commanded(slow_scene(5000, lead(5000))));
  const Case rolled = make_case(commanded(slow_scene(1000, lead(1000, 200), 200)));
  print_line("commanded, lead 1.5", plain);
  print_line("commanded, lead 2.03", leading);
  print_line("commanded, 5 kHz, lead 4.15", fast);
  print_line("commanded, lead 2.83, roll-off 200 Hz", rolled);
  // The other legs' poles at half the rate are within a few per cent of the worst one.
  expect_unstable_as_predicted(leading, 0.05);
  EXPECT_GT(fast.radius, leading.radius);
  expect_stable_as_predicted(rolled);
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <random>

#include "controller/start_check.hpp"
#include "core/control/close_loop.hpp"
#include "core/numerics/worst.hpp"
#include "tests/controller/rig.hpp"

// The bench of the fault policy is the loop that was designed: what follows holds for loops of any
// delay, lead, roll-off and instruments.
namespace stillframe::controller {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

struct Case {
  const char* name;
  double delay = 1, lead = 1.5, rate_hz = 1000, target_hz = 5;
  std::optional<double> roll_off_hz = {};
  Instruments instruments = {};
};

Gains gains_of(const Case& c) {
  Gains gains = toy::damped_gains(c.target_hz, c.rate_hz);
  gains.delay_samples = c.delay;
  gains.lead_samples = c.lead;
  gains.roll_off_hz = c.roll_off_hz;
  gains.instruments = c.instruments;
  gains.force_limit_n = 1e9;  // a linear loop
  return gains;
}

SampledLoop designed(const Gains& gains) {
  return close_loop(sample_and_hold(gains.loop_plant(), gains.sampling()), law_from_gains(gains));
}

/// Quick to the active state, and nothing of the policy in the way of a linear loop.
Policy quick() {
  Policy policy;
  policy.ramp_in_s = 0.05;
  policy.arming_s = 0.2;
  policy.require_motion = false;
  policy.free_rate_n_per_s = 1e12;
  return policy;
}

class RigIsTheDesignedLoop : public testing::TestWithParam<Case> {};

// A floor that has stood still and then is kicked for one sample: the response in y is that of the
// designed loop, sample by sample, to rounding.
TEST_P(RigIsTheDesignedLoop, AnswersToAKickAsTheDesign) {
  const Gains gains = gains_of(GetParam());
  const SampledLoop loop = designed(gains);
  ASSERT_LT(spectral_radius(loop), 1);
  // Rounding of two balanced matrices: what the controller refuses by is of this very loop.
  EXPECT_NEAR(spectral_radius(loop), closed_loop_radius(gains), 1e-12);
  Rig rig(quick(), true, gains);
  rig.floor = [](std::int64_t, VectorXd& w) { w.setZero(); };
  ASSERT_TRUE(rig.reaches(State::active, static_cast<int>(2 * gains.sample_rate_hz)));
  const std::int64_t kick = rig.k();
  rig.floor = [kick](std::int64_t k, VectorXd& w) { w.setConstant(k == kick ? 1 : 0); };
  VectorXd xi = VectorXd::Zero(loop.A.rows());
  const VectorXd w = VectorXd::Ones(loop.B.cols());
  double largest = 0, worst = 0;
  for (int k = 0; k < 3000; ++k) {
    rig.step();
    VectorXd y = loop.C * xi;
    xi = (loop.A * xi).eval();
    if (k == 0) {
      y += loop.D * w;
      xi += loop.B * w;
    }
    largest = worst_of(largest, y.norm());
    worst = worst_of(worst, (rig.y - y).norm());
  }
  EXPECT_EQ(rig.state(), State::active);
  EXPECT_GT(largest, 0);
  // Rounding of 3000 steps of a loop whose forces are some thousand times what they leave of y.
  EXPECT_LT(worst, 1e-9 * largest);
}

INSTANTIATE_TEST_SUITE_P(
    Loops, RigIsTheDesignedLoop,
    testing::Values(Case{"Lead"}, Case{"NoLead", 1, 0}, Case{"NoDelay", 0, 0.5},
                    Case{"DelayTwo", 2, 2.5, 4000}, Case{"FractionalDelay", 1.3, 1.8},
                    Case{"RollOff", 1, 3.99, 5000, 5, 320.0},
                    Case{"Lag", 1, 4.15, 5000, 5, 800.0, {.actuator_lag_hz = 300}},
                    Case{"Filter", 1, 1.5, 5000, 5, {}, {.sensor_filter_hz = 800}},
                    Case{"OldReport",
                         1,
                         1.5,
                         5000,
                         10,
                         300.0,
                         {.report = Instruments::Report::commanded, .report_age_samples = 1}}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace stillframe::controller

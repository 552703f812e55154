#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/actuators.hpp"
#include "plant_sim/force_sensors.hpp"
#include "plant_sim/sensor_errors.hpp"
#include "tests/plant_sim/frame.hpp"
#include "tests/support/allocation_count.hpp"

// Actuators with lag, rate limit and hysteresis, and the sensor filter behind them, against their
// differential equations in many small steps.
namespace stillframe {
namespace {

constexpr double sample_time = 1e-3, force_size = 10;  // s, N
constexpr int n_legs = 3, n_samples = 30;

struct Case {
  const char* name;
  Instruments instruments;
};

constexpr HysteresisLoop loop{.width = 0.12, .swing_n = 8, .saturation_n = 6};
constexpr HysteresisLoop bent{
    .width = 0.1, .swing_n = 8, .saturation_n = 6, .gamma_over_beta = 0.5};

Eigen::MatrixXd commands() { return force_size * test::noise(n_legs, n_samples, 21); }

class ActuatorsTest : public testing::TestWithParam<Case> {};

/// One leg as its differential equations say, f, h and the filtered force together by the classical
/// Runge-Kutta method.
class Brute {
 public:
  static constexpr int steps = 4000;

  explicit Brute(const Instruments& has)
      : has_(has),
        lag_(two_pi * has.actuator_lag_hz),
        filter_(two_pi * has.sensor_filter_hz),
        limit_(has.force_rate_limit) {
    if (has.hysteresis) model_ = bouc_wen(*has.hysteresis);
  }

  void hold(double c, double duration) {
    const double way = c - y_(0);
    if (lag_ > 0) {
      run(duration, [=, this](double f) { return std::clamp(lag_ * (c - f), -limit_, limit_); });
    } else if (std::isfinite(limit_)) {
      const double slewing = std::min(duration, std::abs(way) / limit_);
      run(slewing, [=, this](double) { return std::copysign(limit_, way); });
      run(duration - slewing, [](double) { return 0.0; });
    } else {
      const double filtered = y_(2);  // sees nothing of the way that a jump takes
      run(1, [=](double) { return way; });
      y_(2) = filtered;
      run(duration, [](double) { return 0.0; });
    }
  }

  double force() const { return y_(0); }
  double acting() const { return sigma(y_); }
  double filtered() const { return y_(2); }

 private:
  double sigma(const Eigen::Vector3d& y) const {
    return has_.actuator_gain * (has_.hysteresis ? model_.kappa * y(0) - y(1) : y(0));
  }

  template <typename Rate>
  void run(double duration, const Rate& rate) {
    const auto slope = [&](const Eigen::Vector3d& y) -> Eigen::Vector3d {
      const double f = rate(y(0)), h = y(1);
      return {f, model_.alpha * f - model_.beta * std::abs(f) * h - model_.gamma * f * std::abs(h),
              filter_ * (sigma(y) - y(2))};
    };
    const double dt = duration / steps;
    for (int i = 0; i < steps; ++i) {
      const Eigen::Vector3d a = slope(y_), b = slope(y_ + dt / 2 * a), c = slope(y_ + dt / 2 * b),
                            d = slope(y_ + dt * c);
      y_ += dt / 6 * (a + 2 * b + 2 * c + d);
    }
  }

  Instruments has_;
  double lag_, filter_, limit_;
  BoucWen model_;
  Eigen::Vector3d y_ = Eigen::Vector3d::Zero();
};

TEST_P(ActuatorsTest, DoWhatTheirDifferentialEquationsSay) {
  const Instruments& has = GetParam().instruments;
  const Eigen::MatrixXd u = commands();
  Actuators actuators(n_legs, 0.8 * force_size, has);
  ForceSensors sensors(n_legs, has.sensor_filter_hz);
  std::vector<Brute> brute(n_legs, Brute(has));
  double force = 0, acting = 0, filtered = 0;
  for (int k = 0; k < n_samples; ++k) {
    actuators.command(u.col(k));
    sensors.finish(sample_time, actuators);
    Eigen::VectorXd end(n_legs);
    for (int leg = 0; leg < n_legs; ++leg) end(leg) = actuators.acting(leg, sample_time);
    actuators.finish(sample_time);
    actuators.sample();
    for (int leg = 0; leg < n_legs; ++leg) {
      Brute& one = brute[static_cast<size_t>(leg)];
      one.hold(std::clamp(u(leg, k), -0.8 * force_size, 0.8 * force_size), sample_time);
      force = worst_of(force, std::abs(actuators.report()(leg) - one.force()));
      acting = worst_of(acting, std::abs(end(leg) - one.acting()));
      if (has.sensor_filter_hz > 0) {
        filtered = worst_of(filtered, std::abs(sensors.actuator_part()(leg) - one.filtered()));
      }
    }
  }
  std::cout << GetParam().name << ": force " << force << ", acting " << acting << ", filtered "
            << filtered << "\n";
  // A step of x time constants leaves x^4 / 120, and 4000 of them rounding. Where the slope of f or
  // the second one of h jumps within a step, that step errs by its square, 1e-7 to 1e-5, times a
  // part of what jumps there.
  const bool corners = (std::isfinite(has.force_rate_limit) && has.actuator_lag_hz > 0) ||
                       (has.hysteresis && has.hysteresis->gamma_over_beta != 0);
  const double x =
      two_pi * std::max(has.actuator_lag_hz, has.sensor_filter_hz) * sample_time / Brute::steps;
  const double tolerance = corners ? 1e-7 : 1e-12 + std::pow(x, 4) / 100;
  EXPECT_LT(force, tolerance * force_size);
  EXPECT_LT(acting, tolerance * force_size);
  EXPECT_LT(filtered, tolerance * force_size);
}

TEST_P(ActuatorsTest, GoOnInPartsAsInOne) {
  const Instruments& has = GetParam().instruments;
  const Eigen::MatrixXd u = commands();
  Actuators whole(n_legs, 1e3, has), parts(n_legs, 1e3, has);
  ForceSensors sensor_whole(n_legs, has.sensor_filter_hz), sensor_parts = sensor_whole;
  for (int k = 0; k < n_samples; ++k) {
    whole.command(u.col(k));
    sensor_whole.finish(sample_time, whole);
    whole.finish(sample_time);
    for (const double part : {0.13, 0.4, 0.07, 0.4}) {
      parts.command(u.col(k));
      sensor_parts.finish(part * sample_time, parts);
      parts.finish(part * sample_time);
    }
    whole.sample();
    parts.sample();
    // Rounding, of exponentials and of the quadrature, which has its panels elsewhere.
    EXPECT_LT((whole.report() - parts.report()).norm(), 1e-13 * force_size) << k;
    EXPECT_LT((sensor_whole.actuator_part() - sensor_parts.actuator_part()).norm(),
              1e-13 * force_size)
        << k;
    for (int leg = 0; leg < n_legs; ++leg) {
      EXPECT_NEAR(whole.acting(leg, 0), parts.acting(leg, 0), 1e-13 * force_size);
    }
  }
}

TEST_P(ActuatorsTest, TendToWhereTheySettleAndKeepTheirRate) {
  const Instruments& has = GetParam().instruments;
  const Eigen::MatrixXd u = commands();
  Actuators actuators(n_legs, 1e3, has);
  // kappa and the slope of h against f are below 2.
  const double fastest = 2 * has.actuator_gain * has.force_rate_limit;
  for (int k = 0; k < n_samples; ++k) {
    actuators.command(u.col(k));
    for (int leg = 0; leg < n_legs; ++leg) {
      EXPECT_NEAR(actuators.acting(leg, 1e3), actuators.settled(leg), 1e-14 * force_size);
      double before = actuators.acting(leg, 0);
      for (double t = 1e-5; t < sample_time; t += 1e-5) {
        const double now = actuators.acting(leg, t);
        EXPECT_LE(std::abs(now - before), 1e-5 * fastest * (1 + 1e-9));
        before = now;
      }
    }
    actuators.finish(sample_time);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, ActuatorsTest,
    testing::Values(
        Case{"lag", {.actuator_lag_hz = 300, .sensor_filter_hz = 200}},
        Case{"loop", {.actuator_gain = 1.2, .sensor_filter_hz = 200, .hysteresis = loop}},
        Case{"loop_and_lag", {.actuator_lag_hz = 300, .sensor_filter_hz = 200, .hysteresis = loop}},
        Case{"bent_loop_and_fast_lag",
             {.actuator_gain = 1.2,
              .actuator_lag_hz = 2000,
              .sensor_filter_hz = 900,
              .hysteresis = bent}},
        Case{"loop_and_fast_lag",
             {.actuator_lag_hz = 9000, .sensor_filter_hz = 300, .hysteresis = loop}},
        Case{"loop_and_fast_filter",
             {.actuator_lag_hz = 300, .sensor_filter_hz = 10'000, .hysteresis = loop}},
        Case{"slewing", {.sensor_filter_hz = 200, .force_rate_limit = 8e3}},
        Case{"slewing_behind_lag",
             {.actuator_lag_hz = 300, .sensor_filter_hz = 1000, .force_rate_limit = 8e3}},
        Case{"all",
             {.actuator_gain = 0.8,
              .actuator_lag_hz = 400,
              .sensor_filter_hz = 300,
              .force_rate_limit = 9e3,
              .hysteresis = bent}},
        Case{"all_without_lag",
             {.sensor_filter_hz = 300, .force_rate_limit = 9e3, .hysteresis = bent}}),
    [](const auto& test) { return test.param.name; });

TEST(ActuatorsLimits, AreThoseOfWhatIsLess) {
  // A rate limit that is never met leaves the lag as it is, and a loop that hardly opens the force.
  const Eigen::MatrixXd u = commands();
  const Instruments lag{.actuator_lag_hz = 300, .sensor_filter_hz = 200};
  Instruments free = lag, closed = lag;
  free.force_rate_limit = 1e12;
  closed.hysteresis = loop;
  closed.hysteresis->width = 1e-9;
  Actuators a(n_legs, 8, lag), b(n_legs, 8, free), c(n_legs, 8, closed);
  ForceSensors s_a(n_legs, 200), s_b = s_a, s_c = s_a;
  for (int k = 0; k < n_samples; ++k) {
    for (auto [actuators, sensors] : {std::pair{&a, &s_a}, {&b, &s_b}, {&c, &s_c}}) {
      actuators->command(u.col(k));
      sensors->finish(sample_time, *actuators);
      actuators->finish(sample_time);
    }
    // Rounding; ten times the width, the slope of the loop.
    EXPECT_LT((s_a.actuator_part() - s_b.actuator_part()).norm(), 1e-13 * force_size);
    EXPECT_LT((s_a.actuator_part() - s_c.actuator_part()).norm(), 1e-8 * force_size);
    EXPECT_NEAR(a.acting(0, 0), b.acting(0, 0), 1e-13 * force_size);
    EXPECT_NEAR(a.acting(0, 0), c.acting(0, 0), 1e-8 * force_size);
  }
}

TEST(ActuatorsLimits, SlewingArrivesAndStays) {
  // 4 N and 2 N at 8 N/ms: half a sample and a quarter.
  const Eigen::Vector2d u(4, -2);
  Actuators actuators(2, 100, {.force_rate_limit = 8e3});
  actuators.command(u);
  EXPECT_DOUBLE_EQ(actuators.smooth_for(1e-3), 0.25e-3);
  EXPECT_EQ(actuators.smooth_for(0.2e-3), 0.2e-3);
  EXPECT_EQ(actuators.smooth_for(0.25e-3 * (1 + 1e-10)), 0.25e-3 * (1 + 1e-10));
  EXPECT_DOUBLE_EQ(actuators.acting(0, 0.25e-3), 2);
  EXPECT_EQ(actuators.acting(0, 0.6e-3), 4);
  actuators.finish(0.25e-3);
  actuators.sample();
  EXPECT_DOUBLE_EQ(actuators.report()(0), 2);  // what acts, not what was asked for
  actuators.command(u);
  EXPECT_DOUBLE_EQ(actuators.smooth_for(0.75e-3), 0.25e-3);
  actuators.finish(0.75e-3);
  actuators.sample();
  EXPECT_EQ(actuators.report(), u);
  actuators.command(u);
  EXPECT_EQ(actuators.smooth_for(1e-3), 1e-3);
  // With a lag of 1/6 ms it slews until 8/6 N are left.
  Actuators lagging(2, 100, {.actuator_lag_hz = 6e3 / two_pi, .force_rate_limit = 8e3});
  lagging.command(u);
  EXPECT_DOUBLE_EQ(lagging.smooth_for(1e-3), 0.25e-3 - 1e-3 / 6);
  EXPECT_DOUBLE_EQ(lagging.slewing_ends(0), 0.5e-3 - 1e-3 / 6);
}

TEST(ActuatorsCost, NoAllocation) {
  const Instruments has{.actuator_lag_hz = 400,
                        .sensor_filter_hz = 300,
                        .report_age_samples = 2,
                        .force_rate_limit = 9e3,
                        .hysteresis = bent};
  const Eigen::MatrixXd u = commands();
  Actuators actuators(n_legs, 0.8 * force_size, has);
  ForceSensors sensors(n_legs, has.sensor_filter_hz);
  ForceSensorNoise noise(n_legs,
                         {.noise = 1, .flicker_below_hz = 10, .range = 8, .quantisation = 0.1},
                         sample_time, has.sensor_filter_hz);
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(n_legs);
  const std::int64_t before = test::allocation_count();
  for (int k = 0; k < n_samples; ++k) {
    actuators.command(u.col(k));
    sensors.finish(actuators.smooth_for(sample_time), actuators);
    actuators.finish(sample_time);
    actuators.sample();
    noise.next();
    sigma = actuators.report() + sensors.actuator_part();
    noise.apply(sigma);
  }
  EXPECT_EQ(test::allocation_count() - before, 0);
  // The counter counts: a matrix that is made here goes through it.
  const Eigen::MatrixXd made = Eigen::MatrixXd::Zero(n_legs, 2);
  EXPECT_GT(test::allocation_count() - before, 0) << made.size();
}

TEST(ActuatorsLimits, NothingIsLeftToSlew) {
  const Eigen::MatrixXd u = commands();
  Actuators actuators(n_legs, 1e3, {.force_rate_limit = 3e4, .hysteresis = bent});
  for (int k = 0; k < n_samples; ++k) {
    actuators.command(u.col(k));
    actuators.finish(sample_time);
    actuators.sample();
    EXPECT_EQ(actuators.report(), u.col(k));
    actuators.command(u.col(k));
    EXPECT_EQ(actuators.slewing_ends(0), 0);
  }
}

}  // namespace
}  // namespace stillframe

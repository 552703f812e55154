#include <gtest/gtest.h>

#include <cmath>

#include "core/systems/bouc_wen.hpp"
#include "plant_sim/command_queue.hpp"
#include "tests/plant_sim/frame.hpp"
#include "tests/plant_sim/linear_plant.hpp"
#include "tests/support/allocation_count.hpp"

// The plant's instruments against the linear plant of linear_plant.hpp, on motion so small that the
// nonlinearity is below the integrator's tolerance.
namespace stillframe {
namespace {

constexpr double amplitude = 1e-9;  // m/s^2; forces move the 750 kg as much
constexpr double force_size = 750 * amplitude;
constexpr int n_samples = 200;

/// What of a scene is not ideal, and from which part of a sample on a command acts.
struct Case {
  const char* name;
  Instruments instruments;
  double fraction = 0;
};

/// The frame with unequal and damped legs, whose actuators reach their limit now and then.
Scene scene_of(const Instruments& instruments, double tolerance = 1e-11) {
  Scene scene = test::frame_scene();
  for (SceneElement& element : scene.elements) {
    if (element.kind != SceneElement::Kind::truss) continue;
    if (element.name.back() == 'v') element.stiffness *= 2;
    element.damping = Eigen::MatrixXd::Constant(1, 1, 2e3);
  }
  scene.instruments = instruments;
  scene.controller->force_limit_n = 0.8 * force_size;
  scene.simulation.relative_tolerance = tolerance;
  return scene;
}

/// Sums over all samples: squared differences, and squares of the linear plant's readings.
struct Sums {
  double difference = 0, size = 0;
  void add(const Eigen::VectorXd& is, const Eigen::VectorXd& should) {
    difference += (is - should).squaredNorm();
    size += should.squaredNorm();
  }
  double relative() const { return std::sqrt(difference / size); }
};

struct Differences {
  Sums sigma, report, frame, floor;
};

Differences compare(const Case& c, double tolerance, PlantMethod method = PlantMethod::automatic) {
  Scene scene = scene_of(c.instruments, tolerance);
  scene.simulation.method = method;
  const Model model = make_model(scene);
  const Eigen::MatrixXd w = amplitude * test::noise(6, n_samples, 4);
  const Eigen::MatrixXd u = force_size * test::noise(6, n_samples + 1, 5);
  Plant plant(scene, test::table(w));
  test::LinearPlant linear(scene, model);
  Differences sums;
  for (int k = 0; k < n_samples; ++k) {
    EXPECT_EQ(plant.advance(u.col(k), u.col(k + 1), c.fraction), "");
    linear.advance(u.col(k), u.col(k + 1), c.fraction, w.col(k));
    const Reading& is = plant.read();
    const Reading should = linear.read();
    sums.sigma.add(is.sigma, should.sigma);
    sums.report.add(is.applied_force, should.applied_force);
    sums.frame.add(is.frame_acceleration.head(6), should.frame_acceleration);
    sums.floor.add(is.floor_acceleration, should.floor_acceleration);
  }
  return sums;
}

class InstrumentsTest : public testing::TestWithParam<Case> {};

TEST_P(InstrumentsTest, ReadWhatTheLinearPlantReads) {
  const Differences sums = compare(GetParam(), 1e-11);
  // Rounding of exp(-omega t), some 200 times.
  EXPECT_LT(sums.report.relative(), 1e-13);
  EXPECT_LT(sums.floor.relative(), 1e-15);
  std::cout << GetParam().name << ": sigma " << sums.sigma.relative() << ", frame "
            << sums.frame.relative() << "\n";
  // Twenty tolerances: every sample errs by the tolerance at most, in one direction or the other,
  // and the damped legs forget it within some hundred samples.
  EXPECT_LT(sums.sigma.relative(), 2e-10);
  EXPECT_LT(sums.frame.relative(), 2e-10);
}

constexpr auto commanded = Instruments::Report::commanded;

INSTANTIATE_TEST_SUITE_P(
    Cases, InstrumentsTest,
    testing::Values(Case{"ideal", {}}, Case{"part_of_a_sample", {}, 0.3},
                    Case{"late_in_a_sample", {}, 0.999}, Case{"gain", {.actuator_gain = 1.5}, 0.3},
                    Case{"lag", {.actuator_lag_hz = 300}},
                    Case{"lag_in_parts", {.actuator_lag_hz = 300}, 0.3},
                    Case{"fast_lag", {.actuator_lag_hz = 20e3}, 0.3},
                    Case{"filter", {.sensor_filter_hz = 200}},
                    Case{"filter_in_parts", {.sensor_filter_hz = 200}, 0.3},
                    Case{"slow_filter", {.sensor_filter_hz = 0.1}, 0.3},
                    Case{"fast_filter", {.sensor_filter_hz = 5e3}, 0.3},
                    Case{"equal_corners", {.actuator_lag_hz = 300, .sensor_filter_hz = 300}, 0.3},
                    Case{"commanded", {.actuator_lag_hz = 100, .report = commanded}, 0.3},
                    Case{"aged", {.report_age_samples = 3}, 0.3},
                    // Never met, so that only the lag is left: by the other closed form.
                    Case{"rate_limit_beyond",
                         {.actuator_lag_hz = 300, .sensor_filter_hz = 200, .force_rate_limit = 1},
                         0.3},
                    Case{"all_measured",
                         {.actuator_gain = 0.7,
                          .actuator_lag_hz = 300,
                          .sensor_filter_hz = 200,
                          .report_age_samples = 2},
                         0.3},
                    Case{"all_commanded",
                         {.actuator_gain = 1.3,
                          .actuator_lag_hz = 80,
                          .sensor_filter_hz = 400,
                          .report = commanded,
                          .report_age_samples = 1},
                         0.6}),
    [](const auto& test) { return test.param.name; });

TEST(InstrumentsHysteresis, IsAForceLikeAnother) {
  // Without lag the force that acts is held, and the linear plant can be given it.
  const Case c{"loop",
               {.actuator_gain = 1.2,
                .sensor_filter_hz = 200,
                .hysteresis = HysteresisLoop{.width = 0.1,
                                             .swing_n = force_size,
                                             .saturation_n = force_size,
                                             .gamma_over_beta = 0.3}},
               0.3};
  const Scene scene = scene_of(c.instruments);
  Scene without = scene;
  without.controller->force_limit_n.reset();
  const Model model = make_model(scene);
  const Eigen::MatrixXd w = amplitude * test::noise(6, n_samples, 4);
  const Eigen::MatrixXd u = force_size * test::noise(6, n_samples + 1, 5);
  const double limit = *scene.controller->force_limit_n;
  const Eigen::MatrixXd drive = u.cwiseMax(-limit).cwiseMin(limit);
  const BoucWen loop = bouc_wen(*c.instruments.hysteresis);
  Eigen::MatrixXd acting(6, n_samples + 1);
  for (Eigen::Index leg = 0; leg < 6; ++leg) {
    double f = 0, h = 0;
    for (Eigen::Index k = 0; k <= n_samples; ++k) {
      h = loop.moved(h, drive(leg, k) - f);
      f = drive(leg, k);
      acting(leg, k) = loop.kappa * f - h;
    }
  }
  EXPECT_GT((acting - drive).norm(), 0.02 * drive.norm());  // there is something to see
  Plant plant(scene, test::table(w));
  test::LinearPlant linear(without, model);
  Differences sums;
  for (int k = 0; k < n_samples; ++k) {
    EXPECT_EQ(plant.advance(u.col(k), u.col(k + 1), c.fraction), "");
    linear.advance(acting.col(k), acting.col(k + 1), c.fraction, w.col(k));
    sums.sigma.add(plant.read().sigma, linear.read().sigma);
    sums.frame.add(plant.read().frame_acceleration.head(6), linear.read().frame_acceleration);
    EXPECT_EQ(plant.read().applied_force, drive.col(k + 1));  // what the amplifiers know
  }
  // As of the other instruments above.
  EXPECT_LT(sums.sigma.relative(), 2e-10);
  EXPECT_LT(sums.frame.relative(), 2e-10);
}

TEST(InstrumentsRateLimit, IsARampWithinTheSample) {
  constexpr int parts = 64;
  Scene scene = scene_of({}, 1e-9);
  const double limit = *scene.controller->force_limit_n, rate = scene.controller->sample_rate_hz;
  // The longest way takes nine tenths of a sample.
  scene.instruments.force_rate_limit = 2 * limit * rate / 0.9;
  Scene fine = scene;
  fine.instruments = {};
  fine.controller->sample_rate_hz = parts * rate;
  const Model model = make_model(scene);
  const Eigen::MatrixXd w = amplitude * test::noise(6, n_samples, 4);
  const Eigen::MatrixXd u = force_size * test::noise(6, n_samples, 5);
  Plant plant(scene, test::table(w));
  test::LinearPlant linear(fine, model);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(6), before = force;
  Sums sigma, frame;
  for (int k = 0; k < n_samples; ++k) {
    EXPECT_EQ(plant.advance(u.col(k)), "");
    const Eigen::VectorXd c = u.col(k).cwiseMax(-limit).cwiseMin(limit);
    const double most = scene.instruments.force_rate_limit / rate / parts;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(6);
    for (int i = 0; i < parts; ++i) {
      before = force;
      force += (c - force).cwiseMax(-most).cwiseMin(most);
      linear.advance((before + force) / 2, (before + force) / 2, 0, w.col(k));
      mean += linear.read().frame_acceleration / parts;
    }
    sigma.add(plant.read().sigma, linear.read().sigma);
    frame.add(plant.read().frame_acceleration.head(6), mean);
    EXPECT_EQ(plant.read().applied_force, c);
  }
  // The mean force of each part is right to the square of a part where the ramp ends in it: of the
  // way of a sample (1/64)^2 / 2, 1.2e-4.
  std::cout << "slewing: sigma " << sigma.relative() << ", frame " << frame.relative() << "\n";
  EXPECT_LT(sigma.relative(), 1.2e-4);
  EXPECT_LT(frame.relative(), 1.2e-4);
}

TEST(InstrumentsTolerance, IsWhatRemains) {
  const Case all{
      "all", {.actuator_gain = 0.7, .actuator_lag_hz = 300, .sensor_filter_hz = 200}, 0.3};
  const Differences coarse = compare(all, 1e-4, PlantMethod::dormand_prince),
                    fine = compare(all, 1e-8, PlantMethod::dormand_prince);
  // Ten thousand times finer; a hundred is what the test of the integrator asks for a million.
  std::cout << "sigma " << coarse.sigma.relative() << " to " << fine.sigma.relative() << ", frame "
            << coarse.frame.relative() << " to " << fine.frame.relative() << "\n";
  EXPECT_LT(fine.sigma.relative(), 1e-2 * coarse.sigma.relative());
  EXPECT_LT(fine.frame.relative(), 1e-2 * coarse.frame.relative());
}

TEST(InstrumentsCost, NothingWhereNothingIsNamed) {
  // Where one step goes over a sample, a lag and a filter of a few hundred hertz cost a twelfth of
  // the steps at most; a sample in two parts costs two steps instead of one.
  const auto evaluations = [](const Instruments& instruments, double fraction) {
    Scene scene = scene_of(instruments, 1e-2);
    scene.simulation.method = PlantMethod::dormand_prince;
    Plant plant(scene, test::table(amplitude * test::noise(6, n_samples, 4)));
    const Eigen::VectorXd u = force_size * test::noise(6, 1, 5);
    for (int k = 0; k < n_samples; ++k) EXPECT_EQ(plant.advance(u, u, fraction), "");
    return plant.evaluations();
  };
  const long ideal = evaluations({}, 0);
  EXPECT_EQ(ideal, 10 * n_samples);
  std::cout << "evaluations " << ideal << ", gain and age "
            << evaluations({.actuator_gain = 1.5, .report_age_samples = 2}, 0) << ", lag "
            << evaluations({.actuator_lag_hz = 300}, 0) << ", filter "
            << evaluations({.sensor_filter_hz = 200}, 0) << ", parts " << evaluations({}, 0.3)
            << "\n";
  EXPECT_EQ(evaluations({.actuator_gain = 1.5, .report_age_samples = 2}, 0), ideal);
  EXPECT_LE(evaluations({.actuator_lag_hz = 300}, 0), ideal * 13 / 12);
  EXPECT_LE(evaluations({.sensor_filter_hz = 200}, 0), ideal * 13 / 12);
  EXPECT_EQ(evaluations({}, 0.3), 2 * ideal);
}

TEST(InstrumentsCost, NoAllocation) {
  Scene scene = scene_of({.actuator_gain = 0.7,
                          .actuator_lag_hz = 300,
                          .sensor_filter_hz = 200,
                          .report = commanded,
                          .report_age_samples = 2});
  scene.controller->delay_samples = 2.25;
  const Eigen::MatrixXd u = force_size * test::noise(6, n_samples, 5);
  Plant plant(scene, test::table(amplitude * test::noise(6, n_samples, 4)));
  CommandQueue queue(6, 2.25);
  Eigen::VectorXd command = Eigen::VectorXd::Zero(6);
  // Shared libraries are not counted: SUNDIALS makes its work space in the first sample.
  const std::int64_t before = test::allocation_count();
  bool went_on = true;
  for (int k = 0; k < n_samples; ++k) {
    plant.read();
    went_on = went_on && plant.advance(queue.before(), queue.after(), queue.fraction()).empty();
    command = u.col(k);
    queue.push(command);
  }
  EXPECT_EQ(test::allocation_count() - before, 0);
  EXPECT_TRUE(went_on);
  // The counter counts: a matrix that is made here goes through it.
  const Eigen::MatrixXd made = Eigen::MatrixXd::Zero(command.size(), 2);
  EXPECT_GT(test::allocation_count() - before, 0) << made.size();
}

}  // namespace
}  // namespace stillframe

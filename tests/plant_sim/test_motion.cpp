#include <gtest/gtest.h>

#include <map>
#include <random>

#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/motion/minimal_equations.hpp"
#include "tests/plant_sim/motion_rig.hpp"

namespace stillframe::test {
namespace {

/// Everything that relative_tolerance is a bound on (docs/scene.md, simulation): the error of a run
/// in units of the tolerance, of the accelerations of the frame or of the forces of the legs,
/// whichever is the larger.
double error_in_tolerances(const Eigen::MatrixXd& found, const Eigen::MatrixXd& reference,
                           Index n_legs, double tolerance) {
  const auto of = [&](Index begin, Index count) {
    const auto exact = reference.middleCols(begin, count);
    const double error = (found.middleCols(begin, count) - exact).norm();
    return error == 0 ? 0.0 : error / exact.norm() / tolerance;  // of zero nothing else is right
  };
  const Index n = reference.cols();
  return worst_of(of(0, n - n_legs), of(n - n_legs, n_legs));
}
/// What docs/scene.md promises, in tolerances.
constexpr double promised = 30;

std::vector<PlantMethod> nonlinear_methods() {
  std::vector<PlantMethod> all;
  for (const NamedPlantMethod& each : plant_methods) {
    if (each.method != PlantMethod::linear) all.push_back(each.method);
  }
  return all;
}

/// A reference of another formulation than that of a method.
PlantMethod other_formulation(PlantMethod method) {
  return method == PlantMethod::nodal ? PlantMethod::dormand_prince : PlantMethod::nodal;
}

struct Course {
  std::string name, scene;
  double rate_hz;  ///< 0: that of the scene
  int samples;
  double floor, force;  ///< m/s^2, N
};

class Tolerance : public testing::TestWithParam<Course> {};

/// A floor that swings with the slow modes, and noise: so that small motion grows to large.
Eigen::MatrixXd rising_floor(Index inputs, Index samples, double rate_hz, double amplitude) {
  Eigen::MatrixXd floor = 0.2 * amplitude * noise(inputs, samples, 4);
  for (Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    floor.col(k).array() += amplitude * std::sin(2 * M_PI * 0.8 * t);
  }
  return floor;
}

TEST_P(Tolerance, IsTheErrorOfARunByEveryMethod) {
  const Course& run = GetParam();
  Scene scene = scene_of(run.scene);
  if (run.rate_hz > 0) scene.controller->sample_rate_hz = run.rate_hz;
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  const auto n_inputs = static_cast<Index>(scene.inputs.size());
  const Eigen::MatrixXd forces = run.force * noise(n_legs, run.samples, 3);
  const Eigen::MatrixXd floor =
      rising_floor(n_inputs, run.samples, scene.controller->sample_rate_hz, run.floor);
  std::map<PlantMethod, Eigen::MatrixXd> references;
  for (const PlantMethod method : {PlantMethod::nodal, PlantMethod::dormand_prince}) {
    references[method] = trajectory(with_method(scene, method, 1e-12), forces, floor);
  }
  for (const PlantMethod method : nonlinear_methods()) {
    for (const double tolerance : {1e-5, 1e-8}) {
      const auto found = trajectory(with_method(scene, method, tolerance), forces, floor);
      const double error =
          error_in_tolerances(found, references.at(other_formulation(method)), n_legs, tolerance);
      RecordProperty(method_name(method) + (tolerance < 1e-6 ? "_1e-8" : "_1e-5"),
                     std::to_string(error));
      EXPECT_LT(error, promised) << method_name(method) << " at " << tolerance;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Runs, Tolerance,
    testing::Values(Course{"boom_100hz_passive", "swinging_boom", 100, 500, 5, 0},
                    Course{"boom_100hz", "swinging_boom", 100, 500, 5, 10},
                    Course{"boom_1khz", "swinging_boom", 0, 3000, 5, 5},
                    Course{"boom_quiet", "swinging_boom", 100, 300, 1e-6, 1e-6},
                    Course{"frame_quiet", "metrology_frame", 0, 100, 1e-6, 1e-6},
                    Course{"frame_loud", "metrology_frame", 0, 100, 10, 100},
                    Course{"frame_under_gravity", "frame_under_gravity", 0, 60, 1e-2, 1},
                    Course{"flexible_frame", "frame_flexible", 0, 20, 1e-2, 1}),
    [](const auto& one) { return one.param.name; });

/// Where one spring alone is deformed, what damps its mode is a damper beside it: the boom with a
/// stiff elbow, swinging by a radian.
TEST(ModalDamping, OfOneSpringIsADamperBesideItInLargeMotion) {
  Scene modal = scene_of("swinging_boom");
  for (SceneElement& element : modal.elements) {
    if (element.name != "joint") continue;
    element.zero.assign(1, true);
    element.stiffness.setZero();
    element.damping.setZero();
  }
  modal.dofs.pop_back();
  Scene damper = modal;
  modal.modal_damping = {{{0, 0.05}}, "scene"};
  const Model model = make_model(modal);
  const double c = std::pow(model.modal_dampers(model.deformation_row("rope"), 0), 2);
  EXPECT_GT(c, 0.5);  // as much as the rope has itself
  for (SceneElement& element : damper.elements) {
    if (element.name == "rope") element.damping(0, 0) += c;
  }
  modal.controller->sample_rate_hz = damper.controller->sample_rate_hz = 100;
  const Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(1, 500),
                        floor = rising_floor(1, 500, 100, 5);
  const auto reference = trajectory(with_method(damper, PlantMethod::nodal, 1e-12), forces, floor);
  for (const PlantMethod method :
       {PlantMethod::automatic, PlantMethod::exponential, PlantMethod::dormand_prince}) {
    const auto found = trajectory(with_method(modal, method, 1e-8), forces, floor);
    EXPECT_LT(error_in_tolerances(found, reference, 1, 1e-8), promised) << method_name(method);
  }
  EXPECT_THROW(trajectory(with_method(modal, PlantMethod::nodal, 1e-8), forces, floor), InputError);
}

TEST(ExponentialMotion, AgreesUnderGravityAndInAFlexibleFrame) {
  for (const char* name : {"frame_under_gravity", "frame_flexible"}) {
    const Scene scene = scene_of(name);
    const auto n_w = static_cast<Index>(scene.inputs.size());
    const Eigen::MatrixXd forces = noise(6, 40, 3), floor = 1e-2 * noise(n_w, 40, 4);
    const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-12), forces, floor);
    const auto found =
        trajectory(with_method(scene, PlantMethod::exponential, 1e-10), forces, floor);
    // Two formulations; rounding of legs that carry 1 kN and move by 1 N is some 1e-12.
    EXPECT_LT(relative(found, reference), 1e-9) << name;
  }
}

TEST(ExponentialMotion, HalvesItsPartsWhereTheMotionIsLarge) {
  // The boom swings by more than a radian: the linear part is of no use there, and still no part
  // errs by more than the tolerance: 1500 parts, and a tenth more for each swing that errors grow
  // with.
  const Scene scene = scene_of("swinging_boom");
  Eigen::MatrixXd floor(1, 1500);
  for (Index k = 0; k < floor.cols(); ++k) {
    floor(0, k) = 8 * std::sin(2 * M_PI * 0.8 * static_cast<double>(k) * 1e-3);
  }
  const Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(1, floor.cols());
  const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-12), forces, floor);
  for (const double tolerance : {1e-6, 1e-9}) {
    const auto found =
        trajectory(with_method(scene, PlantMethod::exponential, tolerance), forces, floor);
    EXPECT_LT(relative(found, reference), 1.1 * 1500 * tolerance) << tolerance;
  }
}

/// A pendulum with a light bob on two stiff struts, one of which is let go of a millimetre too
/// long: it rings at about 500 Hz with a thousand times the pendulum's acceleration and comes
/// nowhere.
Scene ringing_pendulum() {
  return parse_scene(R"(
title: A pendulum with a bob that rings
planar: true
operating_point: as_written
gravity: [0, -9.81]
nodes:
  pivot: {position: [0, 0]}
  middle: {position: [0.3, -0.5]}
  tip: {position: [0.3, -0.9]}
  bob: {position: [0.5, -0.9]}
  carriage: {position: [0.8, 0]}
masses:
  - {node: tip, mass: 3, inertia: 0.02}
  - {node: bob, mass: 0.1}
elements:
  upper: {type: rigid_beam, nodes: [pivot, middle]}
  lower: {type: rigid_beam, nodes: [middle, tip]}
  strut: {type: truss, nodes: [tip, bob], stiffness: 1e6}
  stay: {type: truss, nodes: [middle, bob], stiffness: 1e6}
  rope: {type: truss, nodes: [carriage, middle], stiffness: 30, damping: 0.5}
prescribed:
  - {nodes: [pivot, carriage], move: [x, y]}
dofs:
  - {node: pivot, rotation: true}
  - {element: strut, value: 0.001}
  - {element: stay}
inputs:
  - {name: pivot, acceleration: pivot, along: x}
outputs:
  - {name: tip_x, acceleration: tip, along: x}
  - {name: tip_y, acceleration: tip, along: y}
controller: {legs: [rope], target_hz: 0.2, damping_ratio: 0.7, sample_rate_hz: 10, delay_samples: 1, leak_hz: 0.05}
)",
                     "ringing.yaml");
}

// Against what such an acceleration would do in a part any error of the pendulum is small: with as
// much as that counted for the scale, 1760 tolerances by `exponential`, 1067 by `dormand_prince`;
// with what the mode comes to, 29 and 9 at most.
TEST(RingingModes, LoosenNoTolerance) {
  for (const double rate_hz : {10.0, 20.0}) {
    Scene scene = ringing_pendulum();
    scene.controller->sample_rate_hz = rate_hz;
    const Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(1, 10), floor = 0.5 * noise(1, 10, 4);
    const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-10), forces, floor);
    for (const PlantMethod method : nonlinear_methods()) {
      for (const double tolerance : {1e-3, 1e-5}) {
        const auto found = trajectory(with_method(scene, method, tolerance), forces, floor);
        EXPECT_LT(error_in_tolerances(found, reference, 1, tolerance), promised)
            << method_name(method) << " " << rate_hz << " " << tolerance;
      }
    }
  }
}

/// Which parts AdaptiveMotion leaves to the method for large motion.
std::vector<bool> large_parts(const Scene& scene, const Eigen::MatrixXd& floor,
                              const Eigen::MatrixXd& forces) {
  MotionRig rig(scene, PlantMethod::exponential, floor);
  const auto& motion = dynamic_cast<const AdaptiveMotion&>(*rig.motion);
  std::vector<bool> large;
  for (Index k = 0; k < floor.cols(); ++k) {
    rig.drive.take(k);
    EXPECT_TRUE(rig.hold(forces.col(k), 1 / scene.controller->sample_rate_hz));
    large.push_back(motion.is_large());
  }
  return large;
}

TEST(AdaptiveMotion, ChoosesByAmplitudeBothWays) {
  // A frame with damped legs is shaken for 0.15 s by forces that move it by centimetres, which the
  // exponential method would halve its parts for; a second later it is at rest.
  Scene scene = with_method(frame_scene(), PlantMethod::automatic, 1e-6);
  for (SceneElement& element : scene.elements) {
    if (element.kind == SceneElement::Kind::truss) element.damping(0, 0) = 5000;
  }
  const Eigen::MatrixXd floor = Eigen::MatrixXd::Zero(6, 1500);
  Eigen::MatrixXd forces = floor;
  forces.leftCols(150) = 3e4 * noise(6, 150, 3);
  const auto large = large_parts(scene, floor, forces);
  EXPECT_GT(std::count(large.begin(), large.begin() + 200, true), 100);
  EXPECT_EQ(std::count(large.end() - 300, large.end(), true), 0);
  const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-12), forces, floor);
  EXPECT_LT(error_in_tolerances(trajectory(scene, forces, floor), reference, 6, 1e-6), promised);
  // In the small motion of a frame nothing else is tried.
  const auto small = large_parts(with_method(frame_scene(), PlantMethod::automatic, 1e-5),
                                 1e-2 * noise(6, 300, 4), noise(6, 300, 5));
  EXPECT_EQ(std::count(small.begin(), small.end(), true), 0);
}

TEST(AdaptiveMotion, CarriesFiltersAndTurnsFromOneMethodToTheOther) {
  // The boom with a filter behind its force sensor, at 20 samples a second, which makes it stiff:
  // motion is handed to nodal coordinates and back.
  Scene scene = with_method(scene_of("swinging_boom"), PlantMethod::automatic, 1e-8);
  scene.controller->sample_rate_hz = 20;
  scene.instruments.sensor_filter_hz = 2;
  Eigen::MatrixXd floor = Eigen::MatrixXd::Zero(1, 200);
  for (Index k = 0; k < 100; ++k) {
    floor(0, k) = 2 * std::sin(2 * M_PI * 0.8 * static_cast<double>(k) * 0.05);
  }
  const Eigen::MatrixXd forces = noise(1, floor.cols(), 3);
  const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-12), forces, floor);
  EXPECT_LT(error_in_tolerances(trajectory(scene, forces, floor), reference, 1, 1e-8), promised);
}

TEST(ExponentialMotion, KnowsALagAlsoInHalvedParts) {
  Scene scene = scene_of("swinging_boom");
  scene.instruments.actuator_lag_hz = 100;
  Eigen::MatrixXd floor(1, 800);
  for (Index k = 0; k < floor.cols(); ++k) {
    floor(0, k) = 8 * std::sin(2 * M_PI * 0.8 * static_cast<double>(k) * 1e-3);
  }
  const Eigen::MatrixXd forces = 20 * noise(1, floor.cols(), 3);
  const auto reference = trajectory(with_method(scene, PlantMethod::nodal, 1e-12), forces, floor);
  const auto found = trajectory(with_method(scene, PlantMethod::exponential, 1e-10), forces, floor);
  // 800 parts that err by the tolerance, and what errors grow by in a swing.
  EXPECT_LT(relative(found, reference), 1e-10 * 800 * 2);
}

TEST(LinearMotion, IsTheLimitOfSmallMotion) {
  // Nonlinear minus linear response falls with the square of the amplitude, that is the relative
  // difference with the amplitude, from legs that stretch by millimetres down to where rounding is
  // left. Legs stretch by about 1e-5 m per m/s^2 of floor noise.
  const Scene scene = frame_scene();
  const Eigen::MatrixXd shape = noise(6, 100, 4);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(6, 100);
  double before = 0;
  for (int decade = 2; decade >= -7; --decade) {
    const Eigen::MatrixXd floor = std::pow(10.0, decade) * shape;
    const auto nonlinear =
        trajectory(with_method(scene, PlantMethod::exponential, 1e-12), none, floor);
    const auto linear = trajectory(with_method(scene, PlantMethod::linear, 1e-5), none, floor);
    const double difference = relative(nonlinear, linear);
    RecordProperty("difference_at_1e" + std::to_string(decade), std::to_string(difference));
    // Rounding: 1e-16 of the largest numbers in a sample, over 100 samples of which the mean
    // acceleration is a difference of velocities.
    constexpr double rounding = 3e-12;
    if (before > 100 * rounding) {
      EXPECT_NEAR(std::log10(before / difference), 1.0, 0.05) << decade;
    }
    if (decade <= -5) {
      EXPECT_LT(difference, std::max(rounding, 0.2 * before)) << decade;
    }
    before = difference;
  }
}

TEST(LinearMotion, StepsHeldAndLaggedForcesExactly) {
  // The same 10 ms once in ten samples with one command, once in one: exact is exact.
  Scene slow = with_method(frame_scene(), PlantMethod::linear, 1e-5), fast = slow;
  for (Scene* scene : {&slow, &fast}) {
    scene->instruments.actuator_lag_hz = 200;
    scene->instruments.sensor_filter_hz = 300;
  }
  slow.controller->sample_rate_hz = 100;
  Eigen::VectorXd force(6);
  force << 1, -2, 3, 0.5, 0, 1;
  Eigen::VectorXd w(6);
  w << 0.1, 0.2, -0.1, 0, 0.3, -0.2;
  Plant one(slow, table(w)), ten(fast, table(w.replicate(1, 10)));
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(12);
  ASSERT_EQ(one.advance(force), "");
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(ten.advance(force), "");
    mean += ten.read().frame_acceleration / 10;
  }
  // Rounding of ten products.
  EXPECT_LT(relative(one.read().sigma, ten.read().sigma), 1e-13);
  EXPECT_LT(relative(one.read().frame_acceleration, mean), 1e-12);
}

/// Half a second of the boom under a constant force, so that all is smooth: its state at the end,
/// in so many equal samples, and the evaluations it took.
struct Smooth {
  Eigen::VectorXd state;
  double evaluations = 0;
};
Smooth smooth_motion(PlantMethod method, int samples, double tolerance) {
  const Scene scene = with_method(scene_of("swinging_boom"), method, tolerance);
  MotionRig rig(scene, method, Eigen::MatrixXd::Zero(1, 1));
  for (int k = 0; k < samples; ++k) {
    EXPECT_TRUE(rig.hold(Eigen::VectorXd::Constant(1, 5.0), 0.5 / samples));
  }
  return {rig.state(), static_cast<double>(rig.motion->evaluations())};
}

/// To rounding: the finest steps of order 5 that there are.
Eigen::VectorXd smooth_end() {
  return smooth_motion(PlantMethod::dormand_prince, 400, 1e-14).state;
}

TEST(PlantMethodOrder, OfEqualStepsIsThatOfTheTheory) {
  const Eigen::VectorXd exact = smooth_end();
  const auto error = [&](const Smooth& found) { return (found.state - exact).norm(); };
  // The exponential method in one sweep a part (the tolerance asks for no more): its first values
  // are extrapolated with an error of order 3 and the sweep gains one: 4. Swept to the end it is of
  // order 5, that of the collocation.
  const double slow = error(smooth_motion(PlantMethod::exponential, 40, 1e-2));
  const double fast = error(smooth_motion(PlantMethod::exponential, 160, 1e-2));
  EXPECT_NEAR(0.5 * std::log2(slow / fast), 4, 0.2);
}

TEST(PlantMethodOrder, OfControlledStepsShowsInTheirNumber) {
  // The error falls with the number of evaluations to the power of the order. From 1e-6 to 1e-12
  // the step control wanders by half an order.
  const Eigen::VectorXd exact = smooth_end();
  const Smooth coarse = smooth_motion(PlantMethod::dormand_prince, 1, 1e-6);
  const Smooth fine = smooth_motion(PlantMethod::dormand_prince, 1, 1e-12);
  const double order = std::log((coarse.state - exact).norm() / (fine.state - exact).norm()) /
                       std::log(fine.evaluations / coarse.evaluations);
  EXPECT_NEAR(order, 5, 0.5);
}

/// Relative change of the energy of the undamped frame over so many periods of its slowest mode,
/// after a push of all legs, and the largest on the way.
struct Drift {
  double end = 0, largest = 0;
};
Drift energy_drift(PlantMethod method, double tolerance, double periods, double push_n) {
  const Scene scene = with_method(frame_scene(), method, tolerance);
  MotionRig rig(scene, method, Eigen::MatrixXd::Zero(6, 1));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(6);
  EXPECT_TRUE(rig.hold(push_n * noise(6, 1, 8), 5e-3));
  const double start = rig.energy();
  Drift drift;
  const auto n = static_cast<std::int64_t>(periods / 13.9055 * 1000);
  for (std::int64_t k = 1; k <= n; ++k) {
    EXPECT_TRUE(rig.hold(none, 1e-3));
    if (k % 100 != 0 && k != n) continue;
    drift.end = rig.energy() / start - 1;
    drift.largest = worst_of(drift.largest, std::abs(drift.end));
  }
  return drift;
}

TEST(PlantEnergy, OfFreeMotionIsKept) {
  // 100 periods, 7200 samples. A push of 1 kN moves the frame by tenths of a millimetre.
  const Drift exponential = energy_drift(PlantMethod::exponential, 1e-8, 100, 1000);
  const Drift pair = energy_drift(PlantMethod::dormand_prince, 1e-8, 100, 1000);
  RecordProperty("exponential", std::to_string(exponential.largest));
  RecordProperty("dormand_prince", std::to_string(pair.largest));
  // Every sample may add twice its tolerance (energy is of the second degree). The exponential
  // method sweeps until a twentieth of the tolerance is left, and what is left has no sign: it
  // grows with the root of the number of samples, 2 (0.05) 1e-8 sqrt(7200).
  EXPECT_LT(exponential.largest, 0.1e-8 * std::sqrt(7200));
  EXPECT_LT(pair.largest, 2e-8 * 7200);
}

TEST(PlantMethods, GoOnWhereTheFloorHardlyBegins) {
  // The first samples of a floor that is faded in are as small as 1e-20 m/s^2, where positions have
  // no digits left.
  const Eigen::MatrixXd floor = 1e-22 * noise(6, 20, 4), forces = Eigen::MatrixXd::Zero(6, 20);
  for (const PlantMethod method : nonlinear_methods()) {
    const Scene scene = with_method(frame_scene(), method, 1e-10);
    EXPECT_NO_THROW(trajectory(scene, forces, floor)) << method_name(method);
  }
}

/// There is no acceleration anywhere when the first command comes, and the force rises from zero:
/// by a rate limit (N/s), or by a lag.
void expect_to_go_on_from_rest(Scene scene, bool slews, double rate_limit, Index samples,
                               const std::vector<double>& tolerances) {
  (slews ? scene.instruments.force_rate_limit : scene.instruments.actuator_lag_hz) =
      slews ? rate_limit : 50;
  const auto n_legs = static_cast<Index>(scene.controller->legs.size()),
             n_inputs = static_cast<Index>(scene.inputs.size());
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(n_inputs, samples),
                        forces = noise(n_legs, samples, 3);
  const auto run = [&](PlantMethod method, double tolerance) -> Eigen::MatrixXd {
    try {
      return trajectory(with_method(scene, method, tolerance), forces, none);
    } catch (const std::runtime_error& end) {
      ADD_FAILURE() << method_name(method) << " at " << tolerance << ": " << end.what();
      return Eigen::MatrixXd::Constant(samples, static_cast<Index>(scene.outputs.size()) + n_legs,
                                       NAN);
    }
  };
  for (const PlantMethod method :
       {PlantMethod::automatic, PlantMethod::dormand_prince, PlantMethod::nodal}) {
    const Eigen::MatrixXd reference = run(other_formulation(method), 1e-12);
    for (const double tolerance : tolerances) {
      // Two runs at 1e-12 differ by the rounding of both.
      EXPECT_LT(error_in_tolerances(run(method, tolerance), reference, n_legs,
                                    std::max(tolerance, 1e-10)),
                promised)
          << method_name(method) << " at " << tolerance << (slews ? ", slewing" : ", lagging");
    }
  }
}

TEST(PlantMethods, GoOnWhereAForceBeginsToRiseFromRest) {
  for (const bool slews : {true, false}) {
    expect_to_go_on_from_rest(frame_scene(), slews, 2000, 50, {1e-5, 1e-8, 1e-12});
  }
}

/// A mass on three legs that may stand anywhere, every fourth one on a preloaded leg: its rest is a
/// position that was found, with the rounding of that.
Scene random_tripod(unsigned seed) {
  const Eigen::MatrixXd draw = noise(5, 3, seed);
  const auto text = [](double value) { return std::to_string(value); };
  std::string nodes = "nodes: {mass: {position: [0, 0, 0]}", legs = "elements:\n", feet;
  for (Index i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i + 1);
    // Less than a third of a metre off each axis: never in one plane.
    Eigen::Vector3d foot = 0.3 * draw.block<3, 1>(0, i);
    foot(i) += 1;
    nodes += ", foot_" + number + ": {position: [" + text(foot(0)) + ", " + text(foot(1)) + ", " +
             text(foot(2)) + "]}";
    legs += "  leg_" + number + ": {type: truss, nodes: [foot_" + number +
            ", mass], stiffness: " + text(std::pow(10, 6 + draw(3, i))) +
            (i == 0 && seed % 4 == 0 ? ", preload: 300}\n" : "}\n");
    feet += (i > 0 ? ", foot_" : "foot_") + number;
  }
  return parse_scene("title: A random tripod\n" + nodes +
                         "}\nmasses: [{node: mass, mass: " + text(std::pow(10, 2 + draw(4, 0))) +
                         "}]\n" + legs + "prescribed: [{nodes: [" + feet + R"(], move: [x, y, z]}]
dofs: auto
inputs: [{name: floor, acceleration: foot_1, along: x}]
outputs: [{name: mass, acceleration: mass, along: z}]
controller: {legs: [leg_1, leg_2], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1, leak_hz: 0.05}
)",
                     "tripod.yaml");
}

TEST(PlantMethods, OfRandomFramesGoOnWhereAForceBeginsToRiseFromRest) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    for (const bool slews : {true, false}) {
      expect_to_go_on_from_rest(random_tripod(seed), slews, 2000, 20, {1e-5, 1e-12});
    }
  }
}

TEST(PlantChoice, SaysWhyAndRefusesWhatCannotBe) {
  Scene scene = frame_scene();
  EXPECT_EQ(Plant(scene, table(Eigen::MatrixXd::Zero(6, 1))).choice().method,
            PlantMethod::exponential);
  scene.instruments.force_rate_limit = 1e4;
  EXPECT_EQ(Plant(scene, table(Eigen::MatrixXd::Zero(6, 1))).choice().method, PlantMethod::nodal);
  const Scene mast = scene_of("lattice_mast", "bench/scenes");
  EXPECT_EQ(Plant(mast, table(Eigen::MatrixXd::Zero(2, 1))).choice().method, PlantMethod::nodal);
  scene.simulation.method = PlantMethod::linear;
  EXPECT_THROW(Plant(scene, table(Eigen::MatrixXd::Zero(6, 1))), InputError);
}

// In nodal coordinates a rotor accelerates, and the tolerance is of that.
TEST(PlantChoice, BesideARotorIsNeverTheNodalMethod) {
  Scene scene = scene_of("105001003_methods", "tests/random_scenes/found");
  const Eigen::MatrixXd floor = Eigen::MatrixXd::Zero(2, 1);
  EXPECT_EQ(Plant(scene, table(floor)).choice().method, PlantMethod::exponential);
  scene.instruments.force_rate_limit = 1e4;
  EXPECT_EQ(Plant(scene, table(floor)).choice().method, PlantMethod::dormand_prince);
}

class BadRuns : public testing::TestWithParam<PlantMethod> {};

TEST_P(BadRuns, StopWithTimeStateAndReason) {
  // A floor that jumps by kilometres leaves no elongations that the frame could be found by; in
  // nodal coordinates legs of any length are legs, until the numbers end.
  const Scene scene = with_method(frame_scene(), GetParam(), 1e-6);
  Eigen::MatrixXd huge = Eigen::MatrixXd::Zero(6, 10);
  huge(0, 3) = GetParam() == PlantMethod::nodal ? 1e200 : 1e10;
  Plant plant(scene, table(huge));
  std::string reason;
  int k = 0;
  for (; k < 10 && reason.empty(); ++k) reason = plant.advance(Eigen::VectorXd::Zero(6));
  EXPECT_NE(reason.find("plant at t = 0.00"), std::string::npos) << reason;
  EXPECT_NE(reason.find(" m from the operating point"), std::string::npos) << reason;
  EXPECT_GE(k, 4);
}

TEST_P(BadRuns, ForcesThatAreNoNumbersStopTheMotion) {
  const Scene scene = with_method(frame_scene(), GetParam(), 1e-6);
  Plant plant(scene, table(Eigen::MatrixXd::Zero(6, 10)));
  ASSERT_EQ(plant.advance(Eigen::VectorXd::Zero(6)), "");
  EXPECT_NE(plant.advance(Eigen::VectorXd::Constant(6, NAN)), "");
}

INSTANTIATE_TEST_SUITE_P(Methods, BadRuns,
                         testing::Values(PlantMethod::exponential, PlantMethod::dormand_prince,
                                         PlantMethod::nodal));

TEST(PlantStiffness, CostsNothingWhereItIsLinear) {
  // The vertical legs are a billion times as stiff, with 1 % of damping against their mass, so that
  // what they ring with at 0.4 MHz is gone within a sample, as it is in anything real. Evaluations
  // of the equations, not time, so that it is the same on every machine.
  const auto evaluations = [](double ratio) {
    Scene scene = with_method(frame_scene(), PlantMethod::exponential, 1e-5);
    for (SceneElement& element : scene.elements) {
      if (!element.name.ends_with("v")) continue;
      element.stiffness *= ratio;
      const double damping = 2 * 0.01 * std::sqrt(element.stiffness(0, 0) * 750 / 6);
      element.damping = Eigen::MatrixXd::Constant(1, 1, damping);
    }
    Plant plant(scene, table(1e-2 * noise(6, 200, 4)));
    for (int k = 0; k < 200; ++k) {
      EXPECT_EQ(plant.advance(Eigen::VectorXd::Zero(6)), "");
    }
    return static_cast<double>(plant.evaluations()) / 200;
  };
  const double soft = evaluations(1), stiff = evaluations(1e9);
  RecordProperty("soft", std::to_string(soft));
  RecordProperty("stiff", std::to_string(stiff));
  EXPECT_LT(stiff, 3 * soft);
}

/// Nothing acts and nothing is prescribed to move.
class Rest final : public Inputs {
 public:
  void at(double, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot, Eigen::VectorXd& q_r_ddot,
          Eigen::VectorXd& sigma_a) const noexcept override {
    for (Eigen::VectorXd* values : {&q_r, &q_r_dot, &q_r_ddot, &sigma_a}) values->setZero();
  }
  const Eigen::VectorXd& external() const noexcept override { return none_; }

 private:
  Eigen::VectorXd none_;
};

// A solver tries a step that leads nowhere and then a shorter one: that starts where the last good
// one was, not where the first was given up.
TEST(MinimalEquations, GoOnAfterAPositionThatCannotBeReached) {
  const Model model = make_model(frame_scene());
  const NominalMotion nominal = nominal_motion(model);
  MinimalEquations fresh(model, nominal, {}, 0), tried(model, nominal, {}, 0);
  const Rest rest;
  Eigen::VectorXd near = fresh.start(), far = near, expected(near.size()), found(near.size());
  near(0) = 1e-5;
  ASSERT_TRUE(fresh.evaluate(rest, 0, near, expected));
  for (const double elongation : {2.0, -2.0, 30.0}) {
    far(0) = elongation;
    EXPECT_FALSE(tried.evaluate(rest, 0, far, found)) << elongation;
    ASSERT_TRUE(tried.evaluate(rest, 0, near, found)) << elongation;
    // Positions are solved for to some epsilon, from wherever.
    EXPECT_LE((found - expected).norm(), 1e-9 * expected.norm()) << elongation;
  }
}

// The same elongations of a frame's legs are those of several positions. Of those behind a dead
// point the determinant has the other sign, and no motion that the dofs describe comes to them; of
// those of the same sign an attempt that was given up may have found any.
TEST(MinimalEquations, StayOnTheirBranch) {
  const Scene scene = scene_of("105000155_methods", "tests/random_scenes/found");
  const MergedScene merged = merge_rigid_bodies(scene);
  const Model model = make_model(merged.scene);
  const NominalMotion nominal = nominal_motion(model);
  MinimalEquations fresh(model, nominal, {}, 0), tried(model, nominal, {}, 0);
  const Rest rest;
  Eigen::VectorXd near = fresh.start(), far = near, expected(near.size()), found(near.size());
  const int branch = fresh.data().J.sign();
  ASSERT_NE(branch, 0);
  near(0) = 1e-5;
  ASSERT_TRUE(fresh.evaluate(rest, 0, near, expected));
  std::mt19937 engine(59);
  std::uniform_real_distribution<double> elongation(-0.02, 0.02);  // of legs of a decimetre, m
  int reached = 0;
  for (int k = 0; k < 200; ++k) {
    for (Index i = 0; i < model.n_d; ++i) far(i) = elongation(engine);
    if (tried.evaluate(rest, 0, far, found)) {
      EXPECT_EQ(tried.data().J.sign(), branch) << k;
      ++reached;
    }
    tried.go_back();
    ASSERT_TRUE(tried.evaluate(rest, 0, near, found)) << k;
    EXPECT_LE((found - expected).norm(), 1e-9 * expected.norm()) << k;
  }
  EXPECT_GE(reached, 50);
}

// Another formulation may go through a dead point, here the line between the two floors, and leave
// the motion on the branch behind it, where the same elongations are those of the mirror image.
TEST(MinimalEquations, GoOnBehindADeadPointThatAnotherMethodWentThrough) {
  const Model model = make_model(parse_scene(R"(
title: A mass above the line between two floors
nodes:
  left: {position: [-0.4, 0, 0]}
  right: {position: [0.4, 0, 0]}
  mass: {position: [0, 0.3, 0]}
masses:
  - {node: mass, mass: 10}
elements:
  one: {type: truss, nodes: [left, mass], stiffness: 4e3}
  other: {type: truss, nodes: [right, mass], stiffness: 9e3}
supports:
  - {nodes: [left, right], fix: [x, y, z]}
  - {nodes: [mass], fix: [z]}
dofs:
  - {element: one}
  - {element: other}
)",
                                             "two_legs.yaml"));
  const NominalMotion nominal = nominal_motion(model);
  MinimalEquations fresh(model, nominal, {}, 0), behind(model, nominal, {}, 0);
  const Rest rest;
  Eigen::VectorXd y = fresh.start(), expected(y.size()), found(y.size());
  MotionSnapshot through{
      .y = y, .x = fresh.data().x, .x_dot = fresh.data().x_dot, .e = fresh.data().e};
  ASSERT_EQ(through.x.size(), 2);
  through.x(1) -= 0.6;
  behind.take_over(through);
  EXPECT_EQ(behind.data().J.sign(), -fresh.data().J.sign());
  y.head(2) << 1e-3, -2e-3;
  ASSERT_TRUE(fresh.evaluate(rest, 0, y, expected));
  ASSERT_TRUE(behind.evaluate(rest, 0, y, found));
  // Positions are solved for to some epsilon.
  EXPECT_LE((found - expected).norm(), 1e-12 * expected.norm());
  EXPECT_NEAR(behind.data().x(0), fresh.data().x(0), 1e-14);
  EXPECT_NEAR(behind.data().x(1) + fresh.data().x(1), -0.6, 1e-14);
}

}  // namespace
}  // namespace stillframe::test

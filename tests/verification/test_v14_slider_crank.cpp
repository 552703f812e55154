#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <iostream>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/scene_text.hpp"

// V14: a slider-crank whose crank turns at a constant rate.
namespace stillframe::verification {
namespace {

constexpr double crank = 0.3, rod = 0.8;                                // m
constexpr double crank_mass = 0.6, rod_mass = 0.48, slider_mass = 0.5;  // kg
constexpr double as_drawn = 0.5;                                        // rad

struct Reactions {
  double slider_acceleration = 0, motor = 0, bearing_x = 0, bearing_y = 0, side = 0;
};

/// Inverse dynamics of the rigid links, uniform rods with m l^2 / 12, by Newton and Euler. n: along
/// the rod from pin to slider, t: across it.
Reactions by_hand(double angle, double rate) {
  using Eigen::Vector2d;
  const auto cross = [](const Vector2d& a, const Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const Vector2d pin = crank * Vector2d(std::cos(angle), std::sin(angle));
  const double sine = -pin.y() / rod, cosine = std::sqrt(1 - sine * sine);
  const Vector2d n(cosine, sine), t(-sine, cosine);
  const double spin = -crank * std::cos(angle) * rate / (rod * cosine);
  const double spin_up = (pin.y() * rate * rate + rod * sine * spin * spin) / (rod * cosine);
  const Vector2d of_rod = spin_up * t - spin * spin * n, of_pin = -rate * rate * pin;
  const Vector2d middle = of_pin + rod / 2 * of_rod, slider = of_pin + rod * of_rod;
  // Force of the slider on the rod: along x from its mass, along y from moments about the pin.
  Vector2d end(-slider_mass * slider.x(), 0);
  const double moment = rod_mass * rod * rod / 12 * spin_up + rod / 2 * rod_mass * cross(n, middle);
  end.y() = (moment / rod + sine * end.x()) / cosine;
  const Vector2d at_pin = rod_mass * middle - end;  // of the crank on the rod
  const Vector2d bearing = at_pin + crank_mass * of_pin / 2;
  // A stress is positive where it resists: that of the motor is the negative of its torque.
  return {slider.x(), -cross(pin, at_pin), bearing.x(), bearing.y(), end.y()};
}

constexpr const char* signals =
    "inputs: [{name: crank, deformation: motor}, {name: load, force: slider, along: x}]\n"
    "outputs: [{name: a, acceleration: slider, along: x}, {name: motor, stress: motor},"
    " {name: x, reaction: base, along: x}, {name: y, reaction: base, along: y},"
    " {name: side, reaction: slider, along: y}]\n";

std::string at_angle(double angle, double rate) {
  std::string text = without_signals(scene_text("slider_crank"));
  const size_t dofs = text.find("dofs:\n");
  text.replace(dofs, text.find("\n\n", dofs) + 1 - dofs, "dofs:\n  - {deformations: link}\n");
  return with(text, "{element: motor, rate: 10}",
              "{element: motor, value: " + number(angle - as_drawn) + ", rate: " + number(rate) +
                  "}") +
         signals;
}

/// About the snapshot at which the rod is bent and stretched as it has to be to go along: values of
/// the dofs at which q'^d = q''^d = 0, by Newton's method on M q''^d.
LinearModel going_along(const std::string& text) {
  Scene scene = parse_scene(text, "slider-crank");
  for (int k = 0;; ++k) {
    const Model model = make_model(scene);
    const LinearModel linear = linearise(model, scene.inputs, scene.outputs);
    const Eigen::VectorXd step =
        linear.stiffness().partialPivLu().solve(linear.M * linear.q_ddot_0);
    if (k == 10) return linear;
    for (size_t i = 0; i < scene.dofs.size(); ++i) {
      scene.dofs[i].value += step(static_cast<Eigen::Index>(i));
    }
  }
}

/// With a rigid rod nothing is free: a mass on a spring, far away, takes the place of the dof that
/// a scene has to have.
std::string rigid(std::string text) {
  text = with(text, "EA: 4e6, EI: 200, mass_per_length: 0.6, damping_time: 1e-5",
              "rigid: true, mass_per_length: 0.6");
  text = with(text, "nodes:\n  base:",
              "nodes:\n  wall: {position: [5, 5]}\n  ballast: {position: [6, 5]}\n  base:");
  text = with(text, "masses:\n", "masses:\n  - {node: ballast, mass: 1}\n");
  text = with(text, "elements:\n",
              "elements:\n  spring: {type: truss, nodes: [wall, ballast], stiffness: 1}\n");
  text = with(text, "supports:\n",
              "supports:\n  - {nodes: [wall], fix: [x, y]}\n  - {nodes: [ballast], fix: [y]}\n");
  return with(text, "  - {deformations: link}", "  - {element: spring}");
}

/// Stiffness times a factor.
std::string stiffer(const std::string& text, double factor) {
  return with(text, "EA: 4e6, EI: 200",
              "EA: " + number(4e6 * factor) + ", EI: " + number(200 * factor));
}

/// Largest difference of the reactions from those by hand, relative to their size.
double difference(const LinearModel& m, const Reactions& r) {
  Eigen::VectorXd hand(5);
  hand << r.slider_acceleration, r.motor, r.bearing_x, r.bearing_y, r.side;
  const Eigen::VectorXd d = m.y_0 - hand;
  // Accelerations and forces are not the same kind: the acceleration is taken by the slider's mass.
  const double scale = worst_of(hand.tail(4));
  return worst_of(slider_mass * std::abs(d(0)), worst_of(d.tail(4))) / scale;
}

TEST(V14, ReactionsOfRigidLinksAreThoseOfInverseDynamics) {
  double worst = 0;
  for (const double angle : {0.0, 0.5, 1.2, 2.0, 3.0, 4.4, 5.9}) {
    for (const double rate : {10.0, -3.0}) {
      worst = worst_of(
          worst, difference(linear_model(rigid(at_angle(angle, rate))), by_hand(angle, rate)));
    }
  }
  std::cout << "V14: reactions of the rigid slider-crank differ by " << worst
            << " from those by hand\n";
  EXPECT_LE(worst, 1e-13);  // some ten operations on numbers of one size
}

/// The values of the dofs in the scene are those at which it goes along.
TEST(V14, TheSceneItselfGoesAlong) {
  const LinearModel scene = linear_model(scene_text("slider_crank")),
                    settled = going_along(at_angle(as_drawn, 10));
  // Rounding of its stresses, 1e-16 of 4e6 N/m over metres, in a mass of 0.1 kg.
  EXPECT_LE(scene.q_ddot_0.norm(), 1e-7);
  EXPECT_LE((scene.q_0 - settled.q_0).norm(), 1e-14);
}

TEST(V14, ReactionsAndLinearModelConvergeWithTheStiffness) {
  const double angle = 1.2, rate = 10;
  const std::string text = at_angle(angle, rate);
  const Reactions hand = by_hand(angle, rate);
  const LinearModel limit = linear_model(rigid(text));
  const std::complex<double> s(0, 20);
  const Eigen::MatrixXcd G = transfer_function(limit, s);
  double of_reactions = 0, of_model = 0;
  for (const double factor : {1.0, 10.0, 100.0, 1000.0}) {
    const LinearModel m = going_along(stiffer(text, factor));
    const double reactions = difference(m, hand),
                 model = (transfer_function(m, s) - G).norm() / G.norm();
    std::cout << "V14: stiffness times " << factor << ": reactions " << reactions
              << ", transfer functions " << model << " from the rigid limit\n";
    if (of_reactions > 0) {
      // 1 / k, and next terms of that square: less than 1 % of it.
      EXPECT_NEAR(of_reactions / reactions, 10, 0.1) << factor;
      EXPECT_NEAR(of_model / model, 10, 0.1) << factor;
    }
    of_reactions = reactions;
    of_model = model;
  }
}

}  // namespace
}  // namespace stillframe::verification

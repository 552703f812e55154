#include "tests/robustness/frame.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <fstream>
#include <sstream>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe::robustness {

namespace {

const std::string folder = STILLFRAME_SOURCE_DIR "/config/scenes/";

constexpr const char* cart_text = R"(title: A mass on one leg
nodes:
  floor: {position: [0, 0, 0]}
  mass: {position: [1, 0, 0]}
masses:
  - {node: mass, mass: 2}
elements:
  leg: {type: truss, nodes: [floor, mass], stiffness: 800}
supports:
  - {nodes: [floor, mass], fix: [y, z]}
prescribed:
  - {nodes: [floor], move: [x]}
dofs:
  - {element: leg}
inputs:
  - {name: w, acceleration: floor, along: x}
outputs:
  - {name: y, acceleration: mass, along: x}
controller:
  {legs: [leg], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 100, delay_samples: 0, leak_hz: 0}
)";

}  // namespace

FrameLoop::FrameLoop() : scene(read_scene(folder + "metrology_frame.yaml")) {
  const SceneController& controller = *scene.controller;
  const ControlLoop loop = make_control_loop(scene, make_model(scene));
  sampling.sample_time = 1 / controller.sample_rate_hz;
  sampling.delay_samples = controller.delay_samples;
  law = sample_law(loop.gains, {.realisation = controller.realisation,
                                .sample_time = sampling.sample_time,
                                .lead_samples = controller.lead_samples,
                                .sensor_filter_hz = 0});
}

Evaluator FrameLoop::evaluator(const SceneUncertainty& uncertainty) const {
  return Evaluator({.scene = scene,
                    .sampling = sampling,
                    .law = law,
                    .parameters = parameters_of(scene, uncertainty),
                    .frequencies_hz = Eigen::Vector4d(1, 5, 20, 100)});
}

std::string frame_text() {
  std::ifstream file(folder + "metrology_frame.yaml");
  std::stringstream text;
  text << file.rdbuf();
  const std::string all = text.str();
  return all.substr(0, all.find("controller:"));
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_EQ(text.find(from, at + 1), std::string::npos) << from << " stands there twice";
  return text.replace(at, from.size(), to);
}

Eigen::VectorXd only(Eigen::Index p, Eigen::Index j, double value) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(p);
  values(j) = value;
  return values;
}

Evaluator Cart::evaluator(const SceneUncertainty& uncertainty) const {
  Scene scene = parse_scene(cart_text, "cart");
  scene.masses.front().mass = m;
  scene.elements.front().stiffness(0, 0) = k;
  Sampling sampling;
  sampling.sample_time = sample_time;
  const Eigen::MatrixXd D = Eigen::MatrixXd::Constant(1, 1, -kappa);
  return Evaluator({.scene = scene,
                    .sampling = sampling,
                    .law = {.A = Eigen::MatrixXd::Zero(0, 0),
                            .B = Eigen::MatrixXd::Zero(0, 1),
                            .C = Eigen::MatrixXd::Zero(1, 0),
                            .D = D,
                            .subtract_applied = false,
                            .applied_memory = 0},
                    .parameters = parameters_of(scene, uncertainty),
                    .frequencies_hz = Eigen::Vector2d(1, 5)});
}

double Cart::radius(double g) const {
  const double omega = std::sqrt(k / m), c = std::cos(omega * sample_time),
               s = std::sin(omega * sample_time);
  // u pulls the mass to e = -g u / k: e[k+1] = c e + s v - (1 - c) g u / k, v = e'/omega.
  const double push = g / k, from_e = -kappa * k, from_u = -kappa * g;
  Eigen::Matrix3d A;
  A << c - (1 - c) * push * from_e, s, -(1 - c) * push * from_u,  //
      -s - s * push * from_e, c, -s * push * from_u,              //
      from_e, 0, from_u;
  return worst_of(A.eigenvalues());
}

}  // namespace stillframe::robustness

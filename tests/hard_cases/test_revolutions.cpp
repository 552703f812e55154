#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

/// A lop-sided body that spins on an oblique axle, driven by nothing, with a rocker on a spring
/// hinged to it.
const std::string spinner = R"(title: Spinning body with a rocker
nodes:
  ground: {position: [0, 0, 0]}
  body: {position: [0, 0, 0]}
  rocker: {position: [0, 0, 0]}
masses:
  - {node: body, mass: 2, inertia: [0.1, 0.2, 0.25]}
  - {node: rocker, mass: 1, inertia: [[0.03, 0.005, 0], [0.005, 0.04, 0.01], [0, 0.01, 0.05]]}
elements:
  axle: {type: hinge, nodes: [ground, body], axis: [1, 2, 3]}
  pin: {type: hinge, nodes: [body, rocker], axis: [-3, 0, 1], stiffness: 5}
supports:
  - {nodes: [ground], fix: [x, y, z, rotation]}
dofs:
  - {element: axle}
  - {element: pin}
)";

/// One step of the classical Runge-Kutta method of order 4 of (q, q').
class Runner {
 public:
  explicit Runner(const Model& model)
      : model_(model), data_(model), state_(model), sigma_a_(Eigen::VectorXd::Zero(model.n_e)) {}

  Eigen::VectorXd rate(const Eigen::VectorXd& y) {
    state_.q_d = y.head(model_.n_d);
    state_.q_d_dot = y.tail(model_.n_d);
    Eigen::VectorXd q_ddot(model_.n_d), result(y.size());
    EXPECT_EQ(accelerations(model_, data_, state_, sigma_a_, q_ddot), DynamicsStatus::ok);
    result << state_.q_d_dot, q_ddot;
    return result;
  }
  void step(Eigen::VectorXd& y, double h) {
    const Eigen::VectorXd k1 = rate(y), k2 = rate(y + h / 2 * k1), k3 = rate(y + h / 2 * k2),
                          k4 = rate(y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  double energy(const Eigen::VectorXd& y) {
    rate(y);
    return kinetic_energy(model_, data_) + potential_energy(model_, data_);
  }
  const Data& data() const { return data_; }

 private:
  const Model& model_;
  Data data_;
  MotionState state_;
  Eigen::VectorXd sigma_a_;
};

// After 1e4 revolutions lambda^T lambda is 1 to rounding, as it is a condition and not integrated,
// and the energy has drifted no more than the method of order 4 explains: with half the step the
// drift falls by at least 2^4 (energy drifts of this method fall by 2^5).
TEST(ManyRevolutions, KeepTheNormsAndTheEnergy) {
  const Model model = make_model(parse_scene(spinner, "spinner"));
  const auto run = [&](int steps_a_revolution, int revolutions, double& norm_error) {
    Runner runner(model);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(2 * model.n_d);
    y(2) = 20;  // rad/s
    y(3) = 1;
    const double start = runner.energy(y), h = 2 * M_PI / 20 / steps_a_revolution;
    while (y(0) < 2 * M_PI * revolutions) runner.step(y, h);
    norm_error = 0;
    for (const ModelNode& node : model.nodes) {
      Eigen::Vector4d lambda(1, 0, 0, 0);
      for (int i = 0; i < 4; ++i) {
        const Index column = node.rotation.size ? node.rotation.column[static_cast<size_t>(i)] : -1;
        if (column >= 0 && column < model.n_x) lambda(i) += runner.data().x(column);
      }
      norm_error = worst_of(norm_error, std::abs(lambda.squaredNorm() - 1));
    }
    return std::abs(runner.energy(y) / start - 1);
  };
  double norm = 0;
  const double coarse = run(24, 300, norm), fine = run(48, 300, norm);
  EXPECT_LT(fine, coarse / 16);
  const double drift = run(24, 10000, norm);
  reached("1e4 revolutions: lambda^T lambda - 1", norm, 1);
  reached("1e4 revolutions: energy, 24 steps of order 4 a revolution", drift, 1);
  EXPECT_LE(norm, 1e-14);
  EXPECT_LE(drift, 1.5 * coarse * 10000 / 300);  // secular: in proportion to the time
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <iostream>

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// What the nonlinear equations answer to a small change of one variable about the scene as
/// written.
class Nonlinear {
 public:
  Nonlinear(const Scene& scene, const std::vector<SceneSignal>& outputs)
      : model(make_model(scene)), outputs_(outputs), data_(model), load_(model.load) {}

  /// Change of one variable: index and kind as in LinearModel.
  struct Change {
    enum Kind { q, q_dot, input, input_dot, input_ddot } kind;
    Index index;
  };

  /// d(q''; y) of one variable, n_d + n_y, by extrapolated differences.
  VectorXd derivative_to(const Change& change, const std::vector<SceneSignal>& inputs, double h) {
    return derivative([&](double t) { return answer(change, inputs, t); }, h);
  }

  Model model;

 private:
  VectorXd answer(const Change& change, const std::vector<SceneSignal>& inputs, double t) {
    MotionState state(model);
    VectorXd sigma_a = VectorXd::Zero(model.n_e), q_d_ddot(model.n_d);
    model.load = load_;
    if (change.kind == Change::q) state.q_d(change.index) = t;
    if (change.kind == Change::q_dot) state.q_d_dot(change.index) = t;
    if (change.kind >= Change::input) {
      const SceneSignal& input = inputs[static_cast<size_t>(change.index)];
      if (input.quantity == Quantity::stress) {
        sigma_a(model.deformation_row(input.element)) = t;
      } else if (input.quantity == Quantity::force) {
        model.load +=
            t * model.translation_row(model.node_index(input.node), input.direction).transpose();
      } else {
        const VectorXd pattern =
            model.prescribed_pattern(model.node_index(input.node), input.direction, input.place);
        (change.kind == Change::input       ? state.q_r
         : change.kind == Change::input_dot ? state.q_r_dot
                                            : state.q_r_ddot) = t * pattern;
      }
    }
    EXPECT_EQ(accelerations(model, data_, state, sigma_a, q_d_ddot), DynamicsStatus::ok);
    VectorXd result(model.n_d + static_cast<Index>(outputs_.size()));
    result.head(model.n_d) = q_d_ddot;
    for (size_t i = 0; i < outputs_.size(); ++i) {
      result(model.n_d + static_cast<Index>(i)) = output(outputs_[i]);
    }
    return result;
  }

  double output(const SceneSignal& signal) const {
    if (!signal.element.empty()) {
      const Index row = model.deformation_row(signal.element);
      return signal.quantity == Quantity::stress ? data_.sigma(row) : data_.e(row);
    }
    const VectorXd& x = signal.quantity == Quantity::position   ? data_.x
                        : signal.quantity == Quantity::velocity ? data_.x_dot
                                                                : data_.x_ddot;
    return model.translation_row(model.node_index(signal.node), signal.direction).dot(x);
  }

  const std::vector<SceneSignal>& outputs_;
  Data data_;
  VectorXd load_;
};

/// The same derivatives from the matrices of the linear model: q'' and then y.
struct Predicted {
  explicit Predicted(const LinearModel& m) : model(m), M(m.M) {}
  VectorXd rows(const VectorXd& force, const VectorXd& y) const {
    VectorXd result(force.size() + y.size());
    result.head(force.size()) = M.solve(force);
    result.tail(y.size()) = y + model.Y_a * result.head(force.size());
    return result;
  }
  VectorXd to_q(Index i) const { return rows(-(model.K + model.G).col(i), model.Y_p.col(i)); }
  VectorXd to_q_dot(Index i) const { return rows(-model.D.col(i), model.Y_v.col(i)); }
  VectorXd to_input(Index j) const {
    return rows(model.B.col(j) - (model.K_r + model.G_r).col(j),
                model.R_p.col(j) + model.D_u.col(j));
  }
  VectorXd to_input_dot(Index j) const { return rows(-model.D_r.col(j), model.R_v.col(j)); }
  VectorXd to_input_ddot(Index j) const { return rows(-model.M_r.col(j), model.R_a.col(j)); }

  const LinearModel& model;
  const Eigen::LLT<MatrixXd> M;
};

struct NamedScene {
  const char* name;
  Scene scene;
  double step;  ///< of positions, m and 1
};

void PrintTo(const NamedScene& scene, std::ostream* out) { *out << scene.name; }

Scene with_frame_signals(Scene scene) {
  use_all_signals_of_frame(scene);
  return scene;
}
Scene with_mechanism_signals() {
  Scene scene = mechanism();
  use_all_signals_of_mechanism(scene);
  return scene;
}
/// Only the geometric stiffness acts: no element resists its elongation.
Scene without_stiffness(Scene scene) {
  for (SceneElement& element : scene.elements) {
    element.stiffness.setZero();
    element.damping.setZero();
  }
  return scene;
}

class Linearised : public testing::TestWithParam<NamedScene> {
 protected:
  // The target. Extrapolated differences leave (step / 0.15 m)^8 and 1e-16 * (preload, 1e3
  // N) / (k h, 1e4 N).
  static constexpr double tolerance = 1e-9;
};

TEST_P(Linearised, MatricesAreTheDerivativesOfTheNonlinearEquations) {
  const Scene& scene = GetParam().scene;
  Nonlinear nonlinear(scene, scene.outputs);
  const LinearModel linear = linearise(nonlinear.model, scene.inputs, scene.outputs);
  const Predicted predicted(linear);
  const Index n = nonlinear.model.n_d, n_u = static_cast<Index>(scene.inputs.size());
  using Kind = Nonlinear::Change;
  const double h = GetParam().step;
  // Columns of one kind stand side by side; accelerations and each output are judged by their own
  // largest entry.
  const auto compare = [&](const char* what, Kind::Kind kind, Index columns, double step,
                           auto prediction) {
    MatrixXd found(n + linear.Y_p.rows(), columns), expected = found;
    for (Index j = 0; j < columns; ++j) {
      found.col(j) = prediction(j);
      expected.col(j) = nonlinear.derivative_to({kind, j}, scene.inputs, step);
    }
    double worst = 0;
    for (Index i = 0; i < found.rows(); ++i) {
      // Rows that are zero are so up to rounding of the accelerations.
      const double accelerations = std::max(worst_of(expected.topRows(n)), 1e-6);
      const double size = std::max(worst_of(expected.row(i)), (i < n ? 1.0 : 1e-6) * accelerations);
      const double error = worst_of(found.row(i) - expected.row(i));
      EXPECT_LE(error, tolerance * size) << what << " row " << i;
      worst = worst_of(worst, error / size);
    }
    std::cout << GetParam().name << ": " << what << " " << worst << "\n";
  };
  compare("to q", Kind::q, n, h, [&](Index i) { return predicted.to_q(i); });
  compare("to q'", Kind::q_dot, n, 1e-2, [&](Index i) { return predicted.to_q_dot(i); });
  for (Index j = 0; j < n_u; ++j) {
    const SceneSignal& input = scene.inputs[static_cast<size_t>(j)];
    const bool motion = is_motion(input.quantity);
    const auto one = [&](Kind::Kind kind, double step, auto prediction) {
      const VectorXd found = prediction(j),
                     expected = nonlinear.derivative_to({kind, j}, scene.inputs, step);
      // Some inputs drive nothing in one choice of dofs: 1e-6 stands for zero beside answers of
      // 1e-3 and more.
      const double answer = std::max(worst_of(expected.head(n)), 1e-6);
      const double error = worst_of((found - expected).head(n)) / answer;
      EXPECT_LE(error, tolerance) << input.name;
      for (Index i = n; i < found.size(); ++i) {
        // An output that does not answer must be answered with zero: rounding of the largest
        // acceleration at most.
        const double size = std::max(std::abs(expected(i)), 1e-3 * answer);
        EXPECT_LE(std::abs(found(i) - expected(i)), tolerance * size)
            << input.name << " output " << i - n;
      }
      std::cout << GetParam().name << ": to " << input.name << " " << error << "\n";
    };
    one(Kind::input, motion ? h : 100.0, [&](Index k) { return predicted.to_input(k); });
    if (!motion) continue;
    const VectorXd rate = nonlinear.derivative_to({Kind::input_dot, j}, scene.inputs, 1e-2);
    EXPECT_LE(worst_of(predicted.to_input_dot(j) - rate),
              tolerance * std::max(1.0, worst_of(rate)));
    one(Kind::input_ddot, 1.0, [&](Index k) { return predicted.to_input_ddot(k); });
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Linearised,
    testing::Values(NamedScene{"cart_by_position", cart_by_position(), 1e-2},
                    NamedScene{"preloaded_frame", with_frame_signals(preloaded_frame()), 4e-3},
                    NamedScene{"preloaded_by_lens",
                               with_frame_signals(by_lens_coordinates(preloaded_frame())), 4e-3},
                    NamedScene{"preload_alone",
                               with_frame_signals(without_stiffness(preloaded_frame())), 4e-3},
                    NamedScene{"mechanism", with_mechanism_signals(), 1e-2},
                    NamedScene{"mechanism_preload_alone",
                               [] {
                                 Scene scene = without_stiffness(mechanism());
                                 use_all_signals_of_mechanism(scene);
                                 return scene;
                               }(),
                               1e-2}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(Linearisation, MatricesAreSymmetricWhereTheyMustBe) {
  for (const Scene& scene :
       {preloaded_frame(), by_lens_coordinates(preloaded_frame()), mechanism()}) {
    const LinearModel m = linearise(make_model(scene), {}, {});
    for (const MatrixXd* matrix : {&m.M, &m.D, &m.K, &m.G}) {
      EXPECT_LE((*matrix - matrix->transpose()).norm(),
                1e-13 * matrix->norm());  // rounding of the products
    }
    EXPECT_GT(m.G.norm(), 1e-4 * m.K.norm());  // the scenes do have geometric stiffness
  }
}

TEST(Linearisation, AStrungMassHasTheLateralStiffnessOfItsStrings) {
  const double sigma = 50;
  const LinearModel m = linearise(make_model(strung_mass(sigma)), {}, {});
  const double lateral = sigma / 0.5 + sigma / 0.8;
  EXPECT_NEAR(m.K(0, 0), 4000, 1e-10);
  EXPECT_NEAR(m.G(1, 1), lateral, 1e-12 * lateral);
  EXPECT_NEAR(m.G(2, 2), lateral, 1e-12 * lateral);
  EXPECT_NEAR(m.G(0, 0), 0, 1e-12);
  const VectorXd f = modes(m).natural_frequencies_hz;
  EXPECT_NEAR(f(0), std::sqrt(lateral / 4) / (2 * M_PI), 1e-12 * f(0));
  EXPECT_NEAR(f(2), std::sqrt(4000.0 / 4) / (2 * M_PI), 1e-12 * f(2));
}

TEST(Linearisation, CompressedStringsAreRefusedAsUnstable) {
  EXPECT_THROW(modes(linearise(make_model(strung_mass(-50)), {}, {})), Refusal);
}

TEST(Linearisation, InputsThatAreNotThereAreRefused) {
  const Scene scene = frame_scene();
  const Model model = make_model(scene);
  const SceneSignal free = node_signal("w", "mount_1", Quantity::acceleration, Vector3d::UnitX());
  EXPECT_THROW(linearise(model, {free}, {}), InputError);
  const SceneSignal rigid = element_signal("s", "arm_1", Quantity::stress);
  EXPECT_THROW(linearise(model, {rigid}, {}), InputError);
  const SceneSignal unheld = node_signal("r", "mount_1", Quantity::reaction, Vector3d::UnitX());
  EXPECT_THROW(linearise(model, {}, {unheld}), InputError);
  EXPECT_NO_THROW(linearise(model, {}, {rigid}));  // the stress of a rigid element is a reaction
}

/// V1: spring-mass-damper on a cart, closed forms of the deck, section 11.1; m = 2, d = 4, k = 800.
TEST(Cart, ThreeRheonomicCasesAreTheClosedForms) {
  for (Scene scene : {cart_scene(), cart_by_position()}) {
    for (const double f : logarithmic_frequencies(0.01, 1000, 100)) {
      const std::complex<double> s(0, 2 * M_PI * f), d(4.0 / 2), k(800.0 / 2);
      const std::complex<double> G_1 = (d * s + k) / (s * s + d * s + k);
      const std::pair<Quantity, std::complex<double>> cases[] = {
          {Quantity::position, G_1},
          {Quantity::velocity, G_1 / s},
          {Quantity::acceleration, G_1 / (s * s)}};
      for (const auto& [quantity, expected] : cases) {
        scene.inputs.front().quantity = quantity;
        const LinearModel m = linearise(make_model(scene), scene.inputs, scene.outputs);
        // With q = x2 - x1, G_1 at high frequency is the small difference of 1 and -s^2 / (s^2 +
        // ...).
        const double cancellation = std::max(1.0, 1.0 / std::abs(G_1));
        EXPECT_LE(std::abs(transfer_function(m, s)(0, 0) - expected),
                  1e-14 * cancellation * std::abs(expected))
            << f;
      }
    }
  }
}

TEST(Cart, MatricesOfTheDeckWithTheSpringAsDof) {
  const Scene scene = cart_scene();
  const LinearModel m = linearise(make_model(scene), scene.inputs, scene.outputs);
  EXPECT_DOUBLE_EQ(m.K(0, 0) / m.M(0, 0), 400.0);
  EXPECT_DOUBLE_EQ(m.D(0, 0) / m.M(0, 0), 2.0);
  EXPECT_DOUBLE_EQ(m.M_r(0, 0) / m.M(0, 0), 1.0);  // B = [-1 0 0]
  EXPECT_EQ(m.D_r(0, 0), 0.0);
  EXPECT_EQ(m.K_r(0, 0) + m.G_r(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(m.Y_p(0, 0), 1.0);  // C = [1 0], D = [0 0 1]
  EXPECT_DOUBLE_EQ(m.R_p(0, 0), 1.0);
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <numbers>

#include "core/errors/input_error.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/systems/frequency_sweep.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;

LinearModel linear_model(const std::string& name) {
  const Scene scene =
      read_scene(std::string(STILLFRAME_SOURCE_DIR) + "/config/scenes/" + name + ".yaml");
  const Model model = make_model(scene);
  return linearise(model, nominal_motion(model), scene.inputs, scene.outputs);
}

class StateSpaceOf : public testing::TestWithParam<const char*> {};

/// First-order and second-order form are two ways to one transfer function, motion inputs with
/// their three columns, moving scenes and reactions included.
TEST_P(StateSpaceOf, HasTheTransferFunctionOfTheSecondOrderForm) {
  const LinearModel model = linear_model(GetParam());
  const StateSpace system = state_space(model);
  EXPECT_NO_THROW(check_shapes(system));
  FrequencySweep sweep(system);
  MatrixXcd G(sweep.n_outputs(), sweep.n_inputs());
  for (const double f : {0.013, 0.7, 3.3, 41.0, 555.0}) {
    const Complex s(0.1, 2 * std::numbers::pi * f);
    sweep.evaluate(s, G);
    const MatrixXcd expected = transfer_function(model, s);
    for (Index j = 0; j < G.cols(); ++j) {
      // Columns have different units, so each is judged by itself. Both ways lose the condition of
      // the stiffness matrix, 1e8 for the cantilever of eight parts.
      EXPECT_LE((G.col(j) - expected.col(j)).norm(), 1e-8 * expected.col(j).norm())
          << f << " " << j;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, StateSpaceOf,
                         testing::Values("cart", "metrology_frame", "preloaded_frame",
                                         "turning_table", "rotating_cantilever", "slider_crank",
                                         "spinning_arm"),
                         [](const auto& param) { return std::string(param.param); });

TEST(StateSpace, NamesAndOperatingPoint) {
  const LinearModel model = linear_model("spinning_arm");
  const StateSpace system = state_space(model);
  const auto n = static_cast<Index>(model.q_names.size());
  ASSERT_EQ(system.states.size(), model.q_names.size() * 2);
  EXPECT_EQ(system.states[0].name, model.q_names[0]);
  EXPECT_EQ(system.states[model.q_names.size()].name, "d/dt " + model.q_names[0]);
  EXPECT_EQ(system.x0.head(n), model.q_0);
  EXPECT_EQ(system.x0.tail(n), model.q_dot_0);
  EXPECT_EQ(system.u0, model.u_0);
  EXPECT_EQ(system.y0, model.y_0);
}

LinearModel with_mass(const Eigen::MatrixXd& M) {
  LinearModel model = linear_model("turning_table");
  model.M = M;
  return model;
}

TEST(MassFactors, NameTheDofThatMovesNoMass) {
  Eigen::Matrix2d M;
  // Two dofs that move one mass together: singular, and yet rounding lets some of these matrices
  // pass a plain Cholesky factorisation.
  int n_passed = 0;
  for (int k = 2; k < 50; ++k) {
    const Eigen::Vector2d part(1.0 / 3, 1.0 / k);
    M = part * part.transpose();
    n_passed += Eigen::LLT<Eigen::Matrix2d>(M).info() == Eigen::Success;
    EXPECT_THROW(state_space(with_mass(M)), Refusal) << k;
  }
  EXPECT_GT(n_passed, 0);
  M << 2e-9, 0, 0, 0;
  try {
    state_space(with_mass(M));
    FAIL() << "a dof without mass was accepted";
  } catch (const Refusal& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("dof e(spring_y) moves no mass"), std::string::npos)
        << refusal.what();
  }
}

TEST(MassFactors, TakeMassesOfAnyScale) {
  Eigen::Matrix2d M;
  // Grams beside a millionth of a gram times a micrometre squared: small, but there.
  M << 1e-3, 0.9e-12, 0.9e-12, 1e-21;
  EXPECT_NO_THROW(state_space(with_mass(M)));
}

TEST(Modes, GrowingRealEigenvaluesInMotion) {
  LinearModel model = linear_model("turning_table");
  model.M.setIdentity();
  for (Eigen::MatrixXd* block : {&model.C, &model.D, &model.K, &model.G}) block->setZero();
  // s^2 - s - 2 = (s + 1)(s - 2) and s^2 + 3 s - 40 = (s - 5)(s + 8): the one that grows stands
  // behind and before the other.
  model.D = Eigen::Vector2d(-1, 3).asDiagonal();
  model.N = Eigen::Vector2d(-2, -40).asDiagonal();
  const Modes found = modes(model);
  EXPECT_EQ(found.natural_frequencies_hz.size(), 0);
  EXPECT_EQ(found.n_growing, 2);
  EXPECT_EQ(found.damping_ratios, Eigen::Vector2d(-1, -1));
  const double expected[] = {-1, 2, 5, -8};
  for (Index i = 0; i < 4; ++i) {
    // Rounding of simple eigenvalues of a matrix of about 40.
    EXPECT_NEAR(found.eigenvalues(i).real(), expected[i], 1e-13) << i;
  }
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "core/numerics/worst.hpp"
#include "plant_sim/nodal/consistent.hpp"
#include "tests/core/joint_scenes.hpp"
#include "tests/core/scenes.hpp"
#include "tests/plant_sim/nodal_reference.hpp"

namespace stillframe::nodal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_band(Index n, Index b, std::mt19937& engine, BandMatrix& band) {
  MatrixXd dense = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = std::max<Index>(0, i - b); j <= std::min(n - 1, i + b); ++j) {
      // No entry on the diagonal of every third row: exchanges are needed.
      if (i == j && i % 3 == 0) continue;
      dense(i, j) = 2.0 * engine() / 4294967295.0 - 1;
      band.add(i, j, dense(i, j));
    }
  }
  return dense;
}

TEST(BandMatrix, SolvesLikeADenseOne) {
  std::mt19937 engine(3);
  for (const auto& [n, b] :
       std::vector<std::pair<Index, Index>>{{1, 0}, {7, 6}, {40, 3}, {60, 11}}) {
    BandMatrix A_0(n, b), A_1(n, b), A_2(n, b);
    MatrixXd A = random_band(n, b, engine, A_0);
    if (n == 1) A_0.add(0, 0, 2.0), A(0, 0) += 2.0;
    A += 0.1 * random_band(n, b, engine, A_1) + 0.01 * random_band(n, b, engine, A_2);
    const VectorXd exact = test::random_vector(n, engine);
    BandFactors<double> factors(n, b);
    ASSERT_TRUE(factors.factorise(A_0, 0.1, A_1, A_2));
    VectorXd x = A * exact;
    factors.solve(x);
    // Rounding, times the condition of a random matrix of this size (below 1e4).
    EXPECT_LT((x - exact).norm(), 1e-11 * exact.norm()) << n;
    VectorXd product = VectorXd::Ones(n);
    A_0.add_product(exact, product);
    BandFactors<double> alone(n, b);
    ASSERT_TRUE(alone.factorise(A_0));
    product -= VectorXd::Ones(n);
    alone.solve(product);
    EXPECT_LT((product - exact).norm(), 1e-10 * exact.norm()) << n;
  }
  BandFactors<double> singular(3, 1);
  EXPECT_FALSE(singular.factorise(BandMatrix(3, 1)));
}

TEST(BandMatrix, SolvesComplexCombinations) {
  std::mt19937 engine(4);
  const std::complex<double> c(0.1, 0.2);
  BandMatrix A_0(30, 4), A_1(30, 4), A_2(30, 4);
  Eigen::MatrixXcd A = random_band(30, 4, engine, A_0).cast<std::complex<double>>();
  A += c * random_band(30, 4, engine, A_1).cast<std::complex<double>>();
  A += c * c * random_band(30, 4, engine, A_2).cast<std::complex<double>>();
  const Eigen::VectorXcd exact = test::random_vector(30, engine) +
                                 std::complex<double>(0, 1) * test::random_vector(30, engine);
  BandFactors<std::complex<double>> factors(30, 4);
  ASSERT_TRUE(factors.factorise(A_0, c, A_1, A_2));
  Eigen::VectorXcd x = A * exact;
  factors.solve(x);
  EXPECT_LT((x - exact).norm(), 1e-11 * exact.norm());  // as above
}

TEST(NarrowOrdering, FindsTheBandOfAShuffledChain) {
  // 40 links that share one unknown with the next, in a random order: neighbours are at most one
  // group of three apart.
  std::mt19937 engine(5);
  std::vector<Index> name(81);
  for (size_t i = 0; i < name.size(); ++i) name[i] = static_cast<Index>(i);
  std::shuffle(name.begin(), name.end(), engine);
  Groups groups;
  for (size_t i = 0; i < 40; ++i) groups.push_back({name[2 * i], name[2 * i + 1], name[2 * i + 2]});
  std::shuffle(groups.begin(), groups.end(), engine);
  EXPECT_LE(half_bandwidth(narrow_ordering(81, groups), groups), 3);
}

/// What the inputs are at an instant.
struct Instant {
  Model model;
  MotionState motion;
  test::HeldInputs inputs;
  NodalState state;

  Instant(const Scene& scene, unsigned seed)
      : model(make_model(scene)), motion(model), inputs(model) {
    std::mt19937 engine(seed);
    motion = test::random_motion(model, 0.02, 0.5, engine);
    inputs.position = motion.q_r;
    inputs.rate = motion.q_r_dot;
    inputs.acceleration = motion.q_r_ddot;
    for (Index row = 0; row < model.n_e; ++row) {
      if (model.is_elastic(row)) inputs.sigma_a(row) = test::random_vector(1, engine)(0);
    }
  }
};

class NodalEquations : public testing::TestWithParam<int> {
 protected:
  static Scene scene() {
    switch (GetParam()) {
      case 0:
        return test::frame_scene();
      case 1:
        return test::preloaded_frame();
      case 2:
        return test::mechanism();
      case 3:
        return test::slider_crank();
      case 4:
        return test::hinge_chain(3, true);
      case 5:
        return test::free_body();
      case 6: {
        Scene scene = test::free_body();
        SceneLoad turning = test::force_at(scene.nodes.front().name, {3, -1, 2});
        turning.torque = {0.3, 0.2, -0.4};
        scene.loads.push_back(turning);
        turning.follows = true;
        scene.loads.push_back(turning);
        return scene;
      }
      default:
        return test::by_lens_coordinates(test::frame_scene());
    }
  }
};

/// The nodal state of the motion in minimal coordinates, with the reactions of the deck's
/// section 4.
NodalState from_minimal(const Instant& instant, Data& data) {
  VectorXd q_d_ddot(instant.model.n_d);
  EXPECT_EQ(accelerations(instant.model, data, instant.motion, instant.inputs.sigma_a, q_d_ddot),
            DynamicsStatus::ok);
  reaction_stresses(instant.model, data);
  Equations equations(instant.model);
  NodalState state = equations.zero_state();
  state.x = data.x;
  state.x_dot = data.x_dot;
  state.x_ddot = data.x_ddot;
  Index held = 0;
  for (Index row = 0; row < instant.model.n_e; ++row) {
    if (!instant.model.is_elastic(row)) state.lambda(held++) = data.sigma(row);
  }
  return state;
}

TEST_P(NodalEquations, HoldForTheMotionInMinimalCoordinates) {
  const Instant instant(scene(), 11);
  Data data(instant.model);
  ASSERT_TRUE(travel(instant.model, data, MotionState(instant.model), instant.motion));
  NodalState state = from_minimal(instant, data);
  Equations equations(instant.model);
  equations.take_inputs(instant.inputs, 0, state);
  equations.count_turns_from(state);
  VectorXd r(equations.size()), without(equations.size());
  equations.residual(state, r);
  // Rounding of the forces that balance: those of the state without its accelerations, and of the
  // accelerations themselves. 1e-10 leaves room for the condition of the reactions.
  NodalState still = state;
  still.x_ddot.head(equations.n_free()).setZero();
  equations.residual(still, without);
  const Index n = equations.n_free();
  EXPECT_LT(worst_of(r.head(n)), 1e-10 * worst_of(without.head(n)));
  if (equations.n_held() == 0) return;
  EXPECT_LT(worst_of(r.tail(equations.n_held())), 1e-10 * worst_of(state.x_ddot));
  equations.residual(state, r);
  EXPECT_LT((equations.sigma() - data.sigma).norm(), 1e-9 * (1 + data.sigma.norm()));
  equations.position_errors(state, r);
  EXPECT_LT(worst_of(r), 1e-14);
  equations.rate_errors(state, r);
  EXPECT_LT(worst_of(r), 1e-13);
}

TEST_P(NodalEquations, GiveTheAccelerationsOfMinimalCoordinates) {
  const Instant instant(scene(), 12);
  Data data(instant.model);
  ASSERT_TRUE(travel(instant.model, data, MotionState(instant.model), instant.motion));
  const NodalState expected = from_minimal(instant, data);
  Equations equations(instant.model);
  NodalState state = expected;
  equations.take_inputs(instant.inputs, 0, state);
  equations.count_turns_from(state);
  state.x_ddot.head(equations.n_free()).setZero();
  state.lambda.setZero();
  Consistency consistency(equations);
  ASSERT_TRUE(consistency.positions(state));
  ASSERT_TRUE(consistency.rates(state));
  ASSERT_TRUE(consistency.accelerations(state));
  // The rounding of 1e3 forces that nearly cancel.
  EXPECT_LT((state.x - expected.x).norm(), 1e-14 * (1 + expected.x.norm()));
  EXPECT_LT((state.x_ddot - expected.x_ddot).norm(), 1e-10 * expected.x_ddot.norm());
  EXPECT_LT((state.lambda - expected.lambda).norm(), 1e-9 * (1 + expected.lambda.norm()));
}

TEST_P(NodalEquations, DerivativesAgreeWithDifferences) {
  // (M + c C + c^2 K) d = r for the r that differences give along a random direction d of (x'',
  // lambda), x' moving by c x'' and x by c^2 x''.
  const Instant instant(scene(), 13);
  Data data(instant.model);
  ASSERT_TRUE(travel(instant.model, data, MotionState(instant.model), instant.motion));
  NodalState state = from_minimal(instant, data);
  Equations equations(instant.model);
  equations.take_inputs(instant.inputs, 0, state);
  equations.count_turns_from(state);
  std::mt19937 engine(14);
  const Index n = equations.n_free();
  VectorXd direction = test::random_vector(equations.size(), engine);
  for (const double c : {0.0, 0.01, 0.1}) {
    const auto moved = [&](double h) {
      NodalState at = state;
      at.x.head(n) += h * c * c * direction.head(n);
      at.x_dot.head(n) += h * c * direction.head(n);
      at.x_ddot.head(n) += h * direction.head(n);
      at.lambda += h * direction.tail(equations.n_held());
      VectorXd r(equations.size());
      equations.residual(at, r);
      return r;
    };
    // Central differences of fourth order: truncation h^4 and rounding eps / h, both near 1e-10.
    const double h = 1e-3;
    VectorXd product = (8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h);
    equations.differentiate(state, true);
    auto factors = equations.factors<double>();
    ASSERT_TRUE(equations.factorise(factors, c));
    VectorXd solved = product;
    equations.solve(factors, solved);
    // The factors turn the error of the differences by their condition: 1e-5 is far below what a
    // missing term makes.
    EXPECT_LT((solved - direction).norm(), 1e-5 * direction.norm()) << c;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, NodalEquations, testing::Range(0, 8));

}  // namespace
}  // namespace stillframe::nodal

// Octave's control package, given the same plants, gains and settings (cases.hpp), finds the same
// poles, singular values and discretised systems. control_package.m is what it does with them.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <iostream>
#include <numbers>
#include <random>

#include "core/control/continuous_loop.hpp"
#include "core/control/mode_design.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/riccati.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/stein.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "tests/octave/cases.hpp"
#include "tests/octave/difference.hpp"

namespace stillframe::octave {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// What is promised. Rounding grows by the condition of the problem, about (fastest / slowest)^2 of
/// the modes for poles and (0.1 Hz / modes)^-2 for responses, each up to 1e6; the frequencies of
/// cases.hpp and the measures of difference.hpp keep it to that.
constexpr double agreement = 1e-9;

/// The same problem in states x = d z, powers of two, which dare needs to begin at all: those that
/// balance [A, B B^T; Q, A^T].
RiccatiProblem in_balanced_states(const RiccatiProblem& p) {
  const Index n = p.A.rows();
  MatrixXd pencil(2 * n, 2 * n);
  pencil << p.A, p.B * p.R.ldlt().solve(p.B.transpose()), p.Q, p.A.transpose();
  const VectorXd both = balancing_scales(pencil.cwiseAbs());
  VectorXd d(n);
  for (Index i = 0; i < n; ++i) {
    d(i) = std::exp2(std::round(std::log2(both(i) / both(n + i)) / 2));
  }
  const auto S = d.asDiagonal();
  const auto inverse = d.cwiseInverse().asDiagonal();
  return {.A = inverse * p.A * S, .B = inverse * p.B, .Q = S * p.Q * S, .R = p.R, .S = S * p.S};
}

/// The filter and the control problem of H2 laws of virtual modes from 5 to 400 Hz, and others.
std::map<std::string, RiccatiProblem> riccati_cases() {
  std::map<std::string, RiccatiProblem> cases;
  const ModeGoal goal{.omega_d = 2 * std::numbers::pi * 2, .zeta = 0.7, .to_hz = 50};
  for (const double hz : {5.0, 49.0, 137.8, 400.0}) {
    Sampling sampling;
    sampling.sample_time = 1e-3;
    sampling.delay_samples = 1.25;
    const SampledMode mode(2 * std::numbers::pi * hz, sampling, 0);
    const H2Problem p = h2_problem(mode, goal, {.edge_hz = 40, .noise = 2, .noise_hump = 2});
    cases["control_" + std::to_string(hz)] = {.A = p.A,
                                              .B = p.B_u,
                                              .Q = p.C_z.transpose() * p.C_z,
                                              .R = p.D_zu.transpose() * p.D_zu,
                                              .S = p.C_z.transpose() * p.D_zu};
    cases["filter_" + std::to_string(hz)] = {.A = p.A.transpose(),
                                             .B = p.C_e.transpose(),
                                             .Q = p.B_w * p.B_w.transpose(),
                                             .R = p.D_ew * p.D_ew.transpose(),
                                             .S = p.B_w * p.D_ew.transpose()};
  }
  for (auto& [name, problem] : cases) problem = in_balanced_states(problem);
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto draw = [&](Index rows, Index columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(engine); }));
  };
  for (int i = 0; i < 10; ++i) {
    const Index n = 2 + i, m = 1 + i % 3;
    const MatrixXd cost = draw(n + m + 1, n + m), W = cost.transpose() * cost;
    cases["random_" + std::to_string(i)] = {.A = draw(n, n),
                                            .B = draw(n, m),
                                            .Q = W.topLeftCorner(n, n),
                                            .R = W.bottomRightCorner(m, m),
                                            .S = W.topRightCorner(n, m)};
  }
  return cases;
}

/// Octave starts once, for all cases.
const Outcome& outcome() {
  static const Outcome found = [] {
    std::map<std::string, Given> cases;
    for (const OpenCase& c : open_cases()) cases["open_" + c.name] = given(c);
    for (const LoopCase& c : loop_cases()) cases["loop_" + c.name] = given(c);
    for (const auto& [name, p] : riccati_cases()) {
      cases["riccati_" + name] = {{"A", p.A}, {"B", p.B}, {"Q", p.Q}, {"R", p.R}, {"S", p.S}};
    }
    return ask(cases);
  }();
  return found;
}

class Octave : public testing::Test {
 protected:
  void SetUp() override {
    if (!outcome().missing.empty()) {
      GTEST_SKIP() << outcome().missing << " is not installed; scripts/setup installs it";
    }
    ASSERT_EQ(outcome().failure, "");
  }
  void TearDown() override {
    if (!worst_of_.empty())
      std::cout << "  largest difference " << worst_ << ": " << worst_of_ << '\n';
  }

  static const Answer& answer(const OpenCase& c) { return outcome().answers.at("open_" + c.name); }
  static const Answer& answer(const LoopCase& c) { return outcome().answers.at("loop_" + c.name); }

  void expect_agreement(const std::string& name, const std::string& quantity, double difference) {
    EXPECT_LE(difference, agreement) << name << ", " << quantity;
    if (difference >= worst_) {
      worst_ = difference;
      worst_of_ = name + ", " + quantity;
    }
  }

 private:
  double worst_ = 0;
  std::string worst_of_;
};

/// Columns `first` to `first + count` of the inputs, all direct.
StateSpace part_of(const LinearSystem& system, Index first, Index count) {
  StateSpace part;
  part.A = system.A;
  part.B = system.B.middleCols(first, count);
  part.C = system.C;
  part.D = system.D.middleCols(first, count);
  for (Index i = 0; i < count; ++i) part.columns.push_back({InputColumns::Kind::direct, i});
  return part;
}

/// Matrices of states in balanced units, where none hides another.
class Balanced {
 public:
  explicit Balanced(const MatrixXd& Phi) : S_(balancing_scales(Phi)) {}

  MatrixXcd to_states(const MatrixXcd& B) const { return S_.cwiseInverse().asDiagonal() * B; }
  MatrixXcd from_states(const MatrixXcd& C) const { return C * S_.asDiagonal(); }
  MatrixXcd both(const MatrixXcd& A) const { return from_states(to_states(A)); }

 private:
  VectorXd S_;
};

/// A column for each frequency.
template <typename Response>
MatrixXcd over(const VectorXd& omega, const Response& response) {
  MatrixXcd out;
  for (Index k = 0; k < omega.size(); ++k) {
    const VectorXcd column = response(omega(k)).reshaped();
    if (k == 0) out.resize(column.size(), omega.size());
    out.col(k) = column;
  }
  return out;
}

MatrixXcd response(const DiscreteLaw& law, Complex z) {
  MatrixXcd resolvent = -law.A.cast<Complex>();
  resolvent.diagonal().array() += z;
  return law.C * resolvent.partialPivLu().solve(law.B.cast<Complex>()) + law.D;
}

TEST_F(Octave, SeesManyScenes) {
  EXPECT_GE(open_cases().size(), 10u);
  EXPECT_GE(loop_cases().size(), 10u);
}

TEST_F(Octave, FindsThePolesOfScenes) {
  for (const OpenCase& c : open_cases()) {
    expect_agreement(c.name, "poles", pole_difference(c.poles, answer(c).at("poles")));
  }
}

TEST_F(Octave, FindsTheSingularValuesOfScenes) {
  for (const OpenCase& c : open_cases()) {
    expect_agreement(
        c.name, "singular values",
        value_difference(singular_values_over(c.system, c.omega), answer(c).at("values")));
  }
}

TEST_F(Octave, HoldsTheInputsOfScenes) {
  for (const OpenCase& c : open_cases()) {
    const Index n = c.system.A.rows(), p = c.system.C.rows();
    const LoopPlant plant{.A = c.system.A,
                          .B_w = c.system.B,
                          .B_u = MatrixXd::Zero(n, 0),
                          .C_y = c.system.C,
                          .D_yw = c.system.D,
                          .D_yu = MatrixXd::Zero(p, 0),
                          .C_sigma = MatrixXd::Zero(0, n)};
    Sampling sampling;
    sampling.sample_time = c.sample_time;
    const SampledPlant sampled = sample_and_hold(plant, sampling);
    const Balanced in(sampled.Phi);
    const Answer& found = answer(c);
    expect_agreement(c.name, "Phi",
                     matrix_difference(in.both(sampled.Phi), in.both(found.at("Phi"))));
    expect_agreement(
        c.name, "Gamma",
        column_difference(in.to_states(sampled.Gamma_w), in.to_states(found.at("Gamma"))));
  }
}

TEST_F(Octave, FindsThePolesOfLoops) {
  for (const LoopCase& c : loop_cases()) {
    const ForceFeedback& law = c.settings.feedback;
    expect_agreement(
        c.name, "poles",
        pole_difference(closed_loop_poles(c.settings.plant, law), answer(c).at("poles")));
    if (!is_designed_on_its_legs(c)) continue;
    const double omega_d = 30;  // about where the targets are, rad/s
    expect_agreement(c.name, "poles of the design model",
                     pole_difference(closed_loop_poles(c.loop.design.legs, law, omega_d),
                                     answer(c).at("design_poles")));
  }
}

TEST_F(Octave, FindsTheSingularValuesOfLoops) {
  for (const LoopCase& c : loop_cases()) {
    const auto values_of = [](const MatrixXcd& T) { return singular_values(T).eval(); };
    const auto open = [&](double w) { return values_of(c.loop.open(Complex(0, w))); };
    const auto closed = [&](double w) { return values_of(c.loop.closed(Complex(0, w))); };
    const Answer& found = answer(c);
    expect_agreement(c.name, "open loop",
                     value_difference(over(c.omega, open), found.at("values_open")));
    expect_agreement(c.name, "closed loop, T of its parts",
                     value_difference(over(c.omega, closed), found.at("values_closed")));
    const LinearSystem loop = continuous_loop(c.settings.plant, c.settings.feedback);
    const StateSpace T = part_of(loop, 0, c.loop.n_w), N = part_of(loop, c.loop.n_w, c.loop.n_legs);
    expect_agreement(c.name, "closed loop, one system",
                     value_difference(singular_values_over(T, c.omega), found.at("values_closed")));
    expect_agreement(c.name, "noise",
                     value_difference(singular_values_over(N, c.omega), found.at("values_noise")));
  }
}

TEST_F(Octave, SamplesThePlantsOfLoops) {
  for (const LoopCase& c : loop_cases()) {
    const SampledPlant plant = sample_and_hold(c.settings.plant, c.settings.sampling);
    const Answer& found = answer(c);
    const Balanced in(plant.Phi);
    const auto states = [&](const MatrixXd& ours, const char* name) {
      expect_agreement(c.name, name,
                       column_difference(in.to_states(ours), in.to_states(found.at(name))));
    };
    const auto rows = [&](const MatrixXd& ours, const char* name) {
      expect_agreement(c.name, name,
                       matrix_difference(in.from_states(ours), in.from_states(found.at(name))));
    };
    const auto direct = [&](const MatrixXd& ours, const char* name) {
      expect_agreement(c.name, name, matrix_difference(ours, found.at(name)));
    };
    expect_agreement(c.name, "Phi",
                     matrix_difference(in.both(plant.Phi), in.both(found.at("Phi"))));
    states(plant.Gamma_w, "Gamma_w");
    states(plant.Gamma_0, "Gamma_0");
    states(plant.Gamma_u, "Gamma_u");
    rows(plant.C_y, "C_y");
    rows(plant.C_sigma, "C_sigma");
    rows(plant.C_report, "C_report");
    direct(plant.D_yw, "D_yw");
    direct(plant.D_0, "D_0");
    direct(plant.D_yu, "D_yu");
    direct(plant.D_sigma, "D_sigma");
    direct(plant.D_report, "D_report");
  }
}

TEST_F(Octave, SamplesTheLawsOfLoops) {
  for (const LoopCase& c : loop_cases()) {
    const DiscreteLaw law = law_of(c.settings);
    // Lead, law and roll-off are a chain whose links are far larger than its poles: eigenvalues of
    // its matrix in doubles are off by up to 2e-8, Octave's own, of its smaller realisation, are
    // not.
    expect_agreement(c.name, "poles of the law",
                     pole_difference(eigenvalues(extended(law.A)), answer(c).at("law_poles"), 1));
    const auto at = [&](double w) {
      return response(law, std::polar(1.0, w * c.settings.sampling.sample_time));
    };
    expect_agreement(c.name, "response of the law",
                     column_difference(over(c.omega_sampled, at), answer(c).at("law_response")));
  }
}

TEST_F(Octave, ClosesSampledLoops) {
  for (const LoopCase& c : loop_cases()) {
    const SampledPlant plant = sample_and_hold(c.settings.plant, c.settings.sampling);
    const DiscreteLaw law = law_of(c.settings);
    const SampledLoop loop = close_loop(plant, law);
    const Answer& found = answer(c);
    const double radius = found.at("radius")(0).real();
    expect_agreement(c.name, "spectral radius", std::abs(spectral_radius(loop) - radius));
    expect_agreement(c.name, "spectral radius of the feedback part",
                     std::abs(spectral_radius(c.settings) - radius));
    const auto response = [&](const char* name, const auto& ours) {
      expect_agreement(c.name, name,
                       column_difference(over(c.omega_sampled, ours), found.at(name)));
    };
    response("closed_response", [&](double w) { return transfer(loop, w); });
    response("noise_response", [&](double w) { return noise_transfer(loop, w); });
    response("return_ratio", [&](double w) { return return_ratio(plant, law, w); });
  }
}

/// By what X misses its equation, over the size of its terms.
double residual_of(const RiccatiProblem& p, const MatrixXd& X) {
  const MatrixXd AXB = p.A.transpose() * X * p.B + p.S, AXA = p.A.transpose() * X * p.A;
  const MatrixXd last = AXB * (p.R + p.B.transpose() * X * p.B).ldlt().solve(AXB.transpose());
  return (AXA - last + p.Q - X).norm() / (AXA.norm() + last.norm() + p.Q.norm() + X.norm());
}

// dare does not scale its states, and in those of a mode as it is it finds nothing at all. What its
// law costs, as a sum, is the judge: of second order in what the law is off.
TEST_F(Octave, SolvesRiccatiEquations) {
  for (const auto& [name, p] : riccati_cases()) {
    const Answer& theirs = outcome().answers.at("riccati_" + name);
    const RiccatiSolution ours = solve_riccati(p);
    const MatrixXd K = theirs.at("K").real(), X = theirs.at("X").real(), SK = p.S * K;
    EXPECT_LE(residual_of(p, ours.X), 1e-12) << name;
    EXPECT_LE(residual_of(p, ours.X), 100 * residual_of(p, X)) << name;
    const MatrixXd cost = p.Q - SK - SK.transpose() + K.transpose() * p.R * K;
    const MatrixXd summed = solve_stein(p.A - p.B * K, cost);
    const double off = (K - ours.K).norm() / K.norm();
    expect_agreement(name, "cost of its law", (summed - ours.X).norm() / ours.X.norm() - off * off);
    if (name.starts_with("random")) expect_agreement(name, "K", off);
  }
}

}  // namespace
}  // namespace stillframe::octave

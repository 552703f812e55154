#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <deque>
#include <iostream>

#include "core/control/close_loop.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

Sampling at(double sample_time) {
  Sampling sampling;
  sampling.sample_time = sample_time;
  return sampling;
}

/// The same plant with commands that take effect whole samples later.
SampledPlant delayed(SampledPlant plant, int samples) {
  plant.whole_delay.setConstant(samples);
  return plant;
}

/// Mass m on a spring k and damper d, one leg along it: q'' = -(k q + d q' + u) / m - w, y = q'' +
/// w, sigma = k q + d q' + u.
struct Oscillator {
  double m = 2, d = 8, k = 800;

  LoopPlant plant() const {
    LoopPlant p;
    p.A = (MatrixXd(2, 2) << 0, 1, -k / m, -d / m).finished();
    p.B_w = Eigen::Vector2d(0, -1);
    p.B_u = Eigen::Vector2d(0, -1 / m);
    p.C_y = Eigen::RowVector2d(-k / m, -d / m);
    p.D_yw = MatrixXd::Zero(1, 1);
    p.D_yu = MatrixXd::Constant(1, 1, -1 / m);
    p.C_sigma = Eigen::RowVector2d(k, d);
    return p;
  }
};

TEST(SampleAndHold, OscillatorInClosedForm) {
  const Oscillator o;
  const double T = 0.013, a = o.d / (2 * o.m), w = std::sqrt(o.k / o.m - a * a);
  const SampledPlant sampled = sample_and_hold(o.plant(), at(T));
  const double decay = std::exp(-a * T), c = std::cos(w * T), s = std::sin(w * T);
  MatrixXd Phi(2, 2);
  Phi << c + a / w * s, s / w, -(o.k / o.m) / w * s, c - a / w * s;
  Phi *= decay;
  // numbers of order 10 from a scaled and squared exponential
  EXPECT_LE((sampled.Phi - Phi).norm(), 1e-14 * Phi.norm());
  // Held force f: towards the rest position -f / k.
  const Eigen::Vector2d rest(-1 / o.k, 0), held = rest - Phi * rest;
  EXPECT_LE((sampled.Gamma_u - held).norm(), 1e-13 * held.norm());
  EXPECT_LE((sampled.Gamma_w - o.m * held).norm(), 1e-13 * o.m * held.norm());
  EXPECT_EQ(sampled.sample_time, T);
  // The mean of the mass's acceleration q'' + w is the change of its velocity over the interval.
  EXPECT_LE((sampled.C_y - (Phi.row(1) - Eigen::RowVector2d(0, 1)) / T).norm(),
            1e-12 * sampled.C_y.norm());
  EXPECT_NEAR(sampled.D_yu(0, 0), held(1) / T, 1e-12 / o.m);
  EXPECT_NEAR(sampled.D_yw(0, 0), o.m * held(1) / T + 1, 1e-12);
}

TEST(SampleAndHold, AFreeMassIsTheDoubleIntegrator) {
  Oscillator o;
  o.d = o.k = 0;
  const double T = 0.01;
  const SampledPlant sampled = sample_and_hold(o.plant(), at(T));
  EXPECT_NEAR(sampled.Phi(0, 1), T, 1e-17);
  EXPECT_NEAR(sampled.Gamma_w(0, 0), -0.5 * T * T, 1e-18);
  EXPECT_NEAR(sampled.Gamma_w(1, 0), -T, 1e-17);
}

TEST(SampleAndHold, RefusesATimeThatIsNotPositive) {
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), at(0)), std::invalid_argument);
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), at(-1)), std::invalid_argument);
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), at(std::nan(""))), std::invalid_argument);
  Sampling sampling = at(0.01);
  sampling.delay_samples = -0.1;
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), sampling), std::invalid_argument);
  sampling.delay_samples = std::nan("");
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), sampling), std::invalid_argument);
  sampling = at(0.01);
  sampling.leg_gains = VectorXd::Ones(2);
  EXPECT_THROW(sample_and_hold(Oscillator().plant(), sampling), std::invalid_argument);
}

/// A law with a state, m legs: a filtered, coupled feedback of no particular merit but mild.
DiscreteLaw some_law(Index m, bool subtract_applied) {
  DiscreteLaw law;
  law.A = 0.9 * MatrixXd::Identity(m, m);
  law.B = 0.05 * MatrixXd::Identity(m, m);
  law.C = -0.6 * MatrixXd::Identity(m, m);
  law.D = -0.2 * MatrixXd::Identity(m, m);
  if (m > 1) law.A(0, 1) = 0.02, law.C(1, 0) = 0.1, law.D(0, 1) = 0.05;
  law.subtract_applied = subtract_applied;
  return law;
}

/// The loop as it runs, written from the description of the recursion: sample sigma, compute, wait,
/// apply, move on.
class Loop {
 public:
  Loop(const SampledPlant& plant, const DiscreteLaw* law, int delay)
      : plant_(plant),
        law_(law),
        z(VectorXcd::Zero(plant.Phi.rows())),
        x_(VectorXcd::Zero(law ? law->A.rows() : 0)),
        applied_(VectorXcd::Zero(plant.Gamma_u.cols())),
        commands_(static_cast<size_t>(delay), applied_) {}

  /// Takes the floor's acceleration of the coming interval, answers the mean of y over it.
  VectorXcd step(const VectorXcd& w) {
    const VectorXcd sigma = plant_.C_sigma * z + applied_;
    VectorXcd force = VectorXcd::Zero(applied_.size());
    if (law_) {
      const VectorXcd error = law_->subtract_applied ? VectorXcd(sigma - applied_) : sigma;
      commands_.push_back(law_->C * x_ + law_->D * error);
      x_ = VectorXcd(law_->A * x_ + law_->B * error);
      force = commands_.front();
      commands_.pop_front();
    }
    const VectorXcd y = plant_.C_y * z + plant_.D_yw * w + plant_.D_yu * force;
    z = VectorXcd(plant_.Phi * z + plant_.Gamma_w * w + plant_.Gamma_u * force);
    applied_ = force;
    return y;
  }

 private:
  const SampledPlant& plant_;
  const DiscreteLaw* law_;

 public:
  VectorXcd z;

 private:
  VectorXcd x_, applied_;
  std::deque<VectorXcd> commands_;
};

/// Two coupled damped oscillators with two floor inputs and three outputs.
SampledPlant two_legged_plant() {
  LoopPlant p;
  MatrixXd M_inverse(2, 2), K(2, 2);
  M_inverse << 0.5, 0.1, 0.1, 0.4;
  K << 900, 100, 100, 1500;
  const MatrixXd D = 0.02 * K;
  p.A = MatrixXd::Zero(4, 4);
  p.A.topRightCorner(2, 2).setIdentity();
  p.A.bottomRows(2) << -M_inverse * K, -M_inverse * D;
  p.B_w = MatrixXd::Zero(4, 2);
  p.B_w.bottomRows(2) << -1, 0.2, 0.1, -1;
  p.B_u = MatrixXd::Zero(4, 2);
  p.B_u.bottomRows(2) = -M_inverse;
  p.C_y = MatrixXd::Random(3, 4);
  p.C_y << -300, 20, -5, 1, 10, -500, 2, -8, 1, 0, 0.1, 0.3;
  p.D_yw = (MatrixXd(3, 2) << 0.5, 0, 0.1, 0.2, 0, 0.3).finished();
  p.D_yu = (MatrixXd(3, 2) << -0.5, -0.1, -0.1, -0.4, 0, 0).finished();
  p.C_sigma = MatrixXd(2, 4);
  p.C_sigma << K, D;
  return sample_and_hold(p, at(0.01));
}

/// y[k+1] / w[k] once the start has died away, for w[k] = z^k in one input.
VectorXcd measured(Loop loop, Index input, Index n_w, double omega_T, int samples) {
  VectorXcd y;
  for (int k = 0; k < samples; ++k)
    y = loop.step(std::polar(1.0, omega_T * k) * VectorXcd::Unit(n_w, input));
  return y * std::polar(1.0, -omega_T * (samples - 1));
}

class SampledTransfer : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(SampledTransfer, IsWhatTheRunningLoopDoesToAComplexExponential) {
  const auto [delay, subtract] = GetParam();
  const SampledPlant plant = two_legged_plant();
  const DiscreteLaw law = some_law(2, subtract);
  const SampledLoop loop = close_loop(delayed(plant, delay), law);
  ASSERT_LT(spectral_radius(loop), 0.97);  // 2000 samples then leave 1e-26 of the start
  for (const double omega : {1.0, 20.0, 60.0, 250.0}) {
    const MatrixXcd T = transfer(loop, omega);
    for (Index j = 0; j < 2; ++j) {
      const VectorXcd found = measured(Loop(plant, &law, delay), j, 2, omega * 0.01, 2000);
      EXPECT_LE((T.col(j) - found).norm(), 1e-12 * found.norm()) << omega;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(DelaysAndLaws, SampledTransfer,
                         testing::Combine(testing::Values(0, 1, 2, 3), testing::Bool()));

TEST(SampledLoops, OpenLoopIsTheRunningPlantWithoutCommands) {
  const SampledPlant plant = two_legged_plant();
  const SampledLoop loop = open_loop(plant);
  for (const double omega : {1.0, 30.0, 200.0}) {
    for (Index j = 0; j < 2; ++j) {
      const VectorXcd found = measured(Loop(plant, nullptr, 0), j, 2, omega * 0.01, 3000);
      EXPECT_LE((transfer(loop, omega).col(j) - found).norm(), 1e-12 * found.norm());
    }
  }
}

TEST(SampledLoops, AShareOfTheCommandIsALawWithSoMuchLessGain) {
  for (const bool subtract : {false, true}) {
    const DiscreteLaw law = some_law(2, subtract);
    for (const int delay : {0, 1, 3}) {
      const SampledPlant plant = delayed(two_legged_plant(), delay);
      const GainedLoop loop = gain_loop(plant, law);
      EXPECT_EQ(loop.closed.A, close_loop(plant, law).A);
      EXPECT_EQ(loop.at(1).C, loop.closed.C);
      DiscreteLaw weaker = law;
      weaker.C *= 0.3;
      weaker.D *= 0.3;
      for (const double omega : {1.0, 30.0, 200.0}) {
        const auto expect_same = [&](const SampledLoop& a, const SampledLoop& b) {
          EXPECT_LE((transfer(a, omega) - transfer(b, omega)).norm(),
                    1e-12 * transfer(b, omega).norm());
        };
        expect_same(loop.at(0), open_loop(plant));
        expect_same(loop.at(0.3), close_loop(plant, weaker));
        const MatrixXcd v = noise_transfer(close_loop(plant, weaker), omega);
        EXPECT_LE((noise_transfer(loop.at(0.3), omega) - v).norm(), 1e-12 * v.norm());
      }
    }
  }
}

TEST(SampledLoops, ResponseToAnImpulseIsTheSameInBothForms) {
  const SampledPlant plant = two_legged_plant();
  const DiscreteLaw law = some_law(2, true);
  for (const int delay : {0, 1, 2}) {
    const SampledLoop loop = close_loop(delayed(plant, delay), law);
    Loop running(plant, &law, delay);
    VectorXd xi = VectorXd::Zero(loop.A.rows());
    for (int k = 0; k < 50; ++k) {
      const VectorXd w = k == 0 ? VectorXd(Eigen::Vector2d(1, -2)) : VectorXd::Zero(2);
      const VectorXd y = loop.C * xi + loop.D * w;
      xi = VectorXd(loop.A * xi + loop.B * w);
      const VectorXcd found = running.step(w);
      EXPECT_LE((found - y).norm(), 1e-13)
          << found.transpose() << "  " << y.transpose() << delay << " " << k;
    }
  }
}

TEST(SampledLoops, SpectralRadiusIsTheGrowthOfALongRun) {
  const SampledPlant plant = two_legged_plant();
  for (const double gain : {1.0, 3.0, 8.0}) {
    for (const int delay : {0, 1, 2}) {
      DiscreteLaw law = some_law(2, false);
      law.C *= gain;
      law.D *= gain;
      const SampledLoop loop = close_loop(delayed(plant, delay), law);
      std::mt19937 engine(1);
      VectorXd xi = random_vector(loop.A.rows(), engine);
      double logarithm = 0;
      const int steps = 20000;
      for (int k = 0; k < steps; ++k) {
        xi = VectorXd(loop.A * xi);
        const double norm = xi.norm();
        logarithm += std::log(norm);
        xi /= norm;
      }
      // A pair of eigenvalues makes the norm swing by a bounded factor, a few powers of ten at
      // worst: log(1e4) / steps.
      EXPECT_NEAR(logarithm / steps, std::log(spectral_radius(loop)), 5e-4) << gain << " " << delay;
    }
  }
}

TEST(SampledLoops, ALawThatDoesNotFitIsRefused) {
  const SampledPlant plant = two_legged_plant();
  EXPECT_THROW(close_loop(plant, some_law(1, true)), std::invalid_argument);
}

/// The cart with q = x(mass): the floor strains the spring, so its velocity and position are states
/// that w drives.
class CartLoop : public testing::Test {
 protected:
  static constexpr double m_ = 2, d_ = 4, k_ = 800, T_ = 0.02;

  static LinearModel model(Scene scene) {
    scene.inputs = {node_signal("w", "cart", Quantity::acceleration, Eigen::Vector3d::UnitX()),
                    element_signal("u", "spring", Quantity::stress)};
    scene.outputs = {node_signal("y", "mass", Quantity::acceleration, Eigen::Vector3d::UnitX()),
                     element_signal("sigma", "spring", Quantity::stress)};
    return linearise(make_model(scene), scene.inputs, scene.outputs);
  }
  static SampledPlant plant(const Scene& scene) {
    return sample_and_hold(loop_plant(model(scene), 1, 1), at(T_));
  }
};

TEST_F(CartLoop, HasTheFloorAsExogenousStatesWhereItStrainsTheSpring) {
  EXPECT_EQ(plant(cart_by_position()).n_exogenous, 2);
  EXPECT_EQ(plant(cart_scene()).n_exogenous, 0);
}

TEST_F(CartLoop, BothChoicesOfDofGiveOneTransferAndOneRadius) {
  const SampledPlant a = plant(cart_scene()), b = plant(cart_by_position());
  for (const int delay : {0, 1, 2}) {
    const SampledLoop loop_a = close_loop(delayed(a, delay), some_law(1, true)),
                      loop_b = close_loop(delayed(b, delay), some_law(1, true));
    // The floor's double integrator has the radius 1 and is left out.
    EXPECT_NEAR(spectral_radius(loop_a), spectral_radius(loop_b), 1e-12);
    EXPECT_LT(spectral_radius(loop_a), 1.0);
    for (const double omega : {2.0, 20.0, 100.0}) {
      const Complex one = transfer(loop_a, omega)(0, 0), other = transfer(loop_b, omega)(0, 0);
      EXPECT_LE(std::abs(one - other), 1e-11 * std::abs(one))
          << omega;  // 1 / (z - 1)^2 = 600 at the lowest
      const Complex open_a = transfer(open_loop(a), omega)(0, 0),
                    open_b = transfer(open_loop(b), omega)(0, 0);
      EXPECT_LE(std::abs(open_a - open_b), 1e-11 * std::abs(open_a)) << omega;
    }
  }
}

/// The mass and the cart between two samples by Newton's law with very small steps, force and
/// acceleration held.
TEST_F(CartLoop, IsWhatNewtonsLawDoesBetweenTheSamples) {
  const DiscreteLaw law = some_law(1, true);
  for (const int delay : {0, 1}) {
    const SampledLoop loop = close_loop(delayed(plant(cart_by_position()), delay), law);
    for (const double omega : {5.0, 18.0, 60.0}) {
      // Complex floor motion w_k = z^k with its own exact integrals, so that cart and mass do not
      // drift away.
      const Complex z = std::polar(1.0, omega * T_);
      Complex w = 1, v_1 = T_ / (z - 1.0), x_1 = (T_ * v_1 + 0.5 * T_ * T_) / (z - 1.0);
      Complex x_2 = x_1, v_2 = v_1, law_state = 0, applied = 0, y = 0;
      std::deque<Complex> commands(static_cast<size_t>(delay), 0.0);
      const int samples = 1500;
      for (int n = 0; n < samples; ++n, w *= z) {
        const Complex elastic = k_ * (x_2 - x_1) + d_ * (v_2 - v_1);
        const Complex error = (elastic + applied) - applied;
        commands.push_back(law.C(0, 0) * law_state + law.D(0, 0) * error);
        law_state = law.A(0, 0) * law_state + law.B(0, 0) * error;
        applied = commands.front();
        commands.pop_front();
        const int steps = 20;
        const double h = T_ / steps;
        const Complex v_before = v_2;
        for (int i = 0; i < steps;
             ++i) {  // Runge and Kutta: (omega_0 h)^5 = 3e-9 of a step's change
          const auto rate = [&](Complex x, Complex v, double t) {
            return -(k_ * (x - (x_1 + v_1 * t + 0.5 * w * t * t)) + d_ * (v - (v_1 + w * t)) +
                     applied) /
                   m_;
          };
          const double t = i * h;
          const Complex a1 = rate(x_2, v_2, t),
                        a2 = rate(x_2 + 0.5 * h * v_2, v_2 + 0.5 * h * a1, t + 0.5 * h),
                        a3 = rate(x_2 + 0.5 * h * v_2 + 0.25 * h * h * a1, v_2 + 0.5 * h * a2,
                                  t + 0.5 * h),
                        a4 = rate(x_2 + h * v_2 + 0.5 * h * h * a2, v_2 + h * a3, t + h);
          x_2 += h * v_2 + h * h / 6 * (a1 + a2 + a3);
          v_2 += h / 6 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        x_1 += T_ * v_1 + 0.5 * T_ * T_ * w;
        v_1 += T_ * w;
        y = (v_2 - v_before) / T_ / w;
      }
      const Complex found = transfer(loop, omega)(0, 0);
      // The steps' error accumulates over the memory of the loop, some ten samples.
      EXPECT_LE(std::abs(found - y), 1e-6 * std::abs(y)) << omega << " delay " << delay;
    }
  }
}

TEST(SampledLoops, ApproachTheContinuousPlantAsTheSamplesShrink) {
  const Scene scene = frame_scene();
  const ControlLoop loop = make_control_loop(scene, make_model(scene));
  const LoopPlant plant = loop_plant(loop.plant, loop.n_w, loop.n_y);
  const double omega = two_pi * 20;
  std::vector<double> errors;
  for (const double rate : {4000.0, 8000.0}) {
    const MatrixXcd sampled = transfer(open_loop(sample_and_hold(plant, at(1 / rate))), omega);
    // The hold comes half a sample late, the mean half a sample early, and both take (sin x) / x of
    // the size.
    const MatrixXcd continuous = loop.open({0, omega});
    errors.push_back((sampled - continuous).norm() / continuous.norm());
  }
  EXPECT_LE(errors[0], 0.01);
  EXPECT_NEAR(errors[0] / errors[1], 4.0, 0.4);  // second order in the sample time
}

TEST(Balancing, BringsRowsAndColumnsTogetherAndChangesNoDigit) {
  std::mt19937 engine(3);
  MatrixXd A(6, 6);
  for (Index j = 0; j < 6; ++j) A.col(j) = random_vector(6, engine);
  const VectorXd units = (VectorXd(6) << 1e-6, 1e3, 1, 1e7, 1e-9, 30).finished();
  const MatrixXd bad = units.asDiagonal() * A * units.cwiseInverse().asDiagonal();
  const VectorXd S = balancing_scales(bad);
  const MatrixXd good = S.cwiseInverse().asDiagonal() * bad * S.asDiagonal();
  for (Index i = 0; i < 6; ++i) {
    int exponent = 0;
    EXPECT_EQ(std::frexp(S(i), &exponent), 0.5) << "a power of two";
    const double own = std::abs(good(i, i));
    const double ratio = (good.row(i).lpNorm<1>() - own) / (good.col(i).lpNorm<1>() - own);
    EXPECT_GT(
        ratio,
        1 / 4.0);  // a step is a factor 4 in this ratio, and one below 5 % of the norm is not taken
    EXPECT_LT(ratio, 4.0);
  }
  EXPECT_EQ((S.asDiagonal() * good * S.cwiseInverse().asDiagonal() - bad).norm(), 0.0);
  EXPECT_EQ(balancing_scales(MatrixXd::Zero(3, 3)), VectorXd::Ones(3));
}

TEST(LoopPlant, RefusesInputsAndOutputsOfAnotherKind) {
  const Scene scene = frame_scene();
  const LinearModel m = linearise(make_model(scene), scene.inputs, scene.outputs);
  EXPECT_THROW(loop_plant(m, 5, 6), std::invalid_argument);
  EXPECT_THROW(loop_plant(m, 6, 5), std::invalid_argument);
}

// Many exogenous states, as those of a feed-forward, are solved before the loop that they drive; it
// is the same transfer function as with all at once.
TEST(SampledLoop, ExogenousStatesAreSolvedApart) {
  constexpr Eigen::Index e = 60, n = 9, p = 3, n_y = 4;
  std::srand(1);
  SampledLoop loop{.A = MatrixXd::Zero(e + n, e + n),
                   .B = MatrixXd::Random(e + n, p),
                   .B_v = MatrixXd::Random(e + n, 2),
                   .C = MatrixXd::Random(n_y, e + n),
                   .D = MatrixXd::Random(n_y, p),
                   .D_v = MatrixXd::Random(n_y, 2),
                   .n_exogenous = e,
                   .sample_time = 1e-3};
  // Chains of samples before, of three channels, and a slow integral of each.
  for (Eigen::Index i = p; i < e; ++i) loop.A(i, i - p) = 1;
  loop.A.topLeftCorner(e, e).diagonal().tail(p).setConstant(0.99);
  loop.A.bottomRows(n) = 0.2 * MatrixXd::Random(n, e + n);
  for (const double hz : {0.1, 3.0, 77.0, 499.0}) {
    const MatrixXcd G = transfer(loop, two_pi * hz), N = noise_transfer(loop, two_pi * hz);
    MatrixXcd resolvent = -loop.A.cast<Complex>();
    resolvent.diagonal().array() += std::polar(1.0, two_pi * hz * loop.sample_time);
    const MatrixXcd inverse = resolvent.inverse();
    const MatrixXcd all = loop.C * inverse * loop.B + loop.D,
                    noise = loop.C * inverse * loop.B_v + loop.D_v;
    EXPECT_LT((G - all).norm(), 1e-11 * all.norm()) << hz;
    EXPECT_LT((N - noise).norm(), 1e-11 * noise.norm()) << hz;
  }
}

}  // namespace
}  // namespace stillframe::test

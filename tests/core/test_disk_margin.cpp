#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/control/disk_margin.hpp"
#include "core/control/margins.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/random_loops.hpp"

// Peaks are found from a state space of S - I/2; here they are held against return_ratio, which is
// another formulation, and against the eigenvalues of perturbed loops.
namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// S - I/2 from the return ratio, omega in rad/s.
class FromReturnRatio {
 public:
  explicit FromReturnRatio(const LoopSettings& loop)
      : plant_(sample_and_hold(feedback_part(loop.plant), loop.sampling)), law_(law_of(loop)) {}
  MatrixXcd operator()(double omega) const {
    const MatrixXcd L = return_ratio(plant_, law_, omega);
    const MatrixXcd I = MatrixXcd::Identity(L.rows(), L.rows());
    return (I + L).inverse() - 0.5 * I;
  }

 private:
  SampledPlant plant_;
  DiscreteLaw law_;
};

/// Spectral radius of the loop whose legs' forces act `factors` times.
double radius_with(const LinearSystem& half, const VectorXcd& factors) {
  const MatrixXcd off = (factors.array() - 1).matrix().asDiagonal();
  const MatrixXcd A = half.A.cast<Complex>() + half.B * off * half.C;
  const Eigen::ComplexEigenSolver<MatrixXcd> solver(A, false);
  EXPECT_EQ(solver.info(), Eigen::Success);
  return worst_of(solver.eigenvalues());
}

Complex factor(Complex d) { return (2.0 + d) / (2.0 - d); }

/// 10 kg on 4e5 N/m and 20 N s/m, and on it 0.3 kg at `hz`, damped by 2e-5; 1 kHz, a delay of one
/// sample, no lead, 5 Hz, zeta 0.7, leak 0.05 Hz.
LoopSettings with_resonance(double hz) {
  constexpr double m = 10, k = 4e5, d = 20, m_2 = 0.3, omega_d = two_pi * 5;
  const double omega = two_pi * hz, k_2 = m_2 * omega * omega, d_2 = 2 * 2e-5 * m_2 * omega;
  LoopSettings out;
  out.plant.A = (MatrixXd(4, 4) << 0, 0, 1, 0,                      //
                 0, 0, 0, 1,                                        //
                 -(k + k_2) / m, k_2 / m, -(d + d_2) / m, d_2 / m,  //
                 k_2 / m_2, -k_2 / m_2, d_2 / m_2, -d_2 / m_2)
                    .finished();
  out.plant.B_w = MatrixXd::Zero(4, 0);
  out.plant.B_u = VectorXd{{0, 0, -1 / m, 0}};
  out.plant.C_y = MatrixXd::Zero(0, 4);
  out.plant.D_yw = MatrixXd::Zero(0, 0);
  out.plant.D_yu = MatrixXd::Zero(0, 1);
  out.plant.C_sigma = Eigen::RowVectorXd{{k, 0, d, 0}};
  const double X = k / ((m + m_2) * omega_d * omega_d);
  out.feedback = {.K_P = MatrixXd::Constant(1, 1, X - 1),
                  .K_I = MatrixXd::Constant(1, 1, 1.4 * omega_d * X),
                  .leak = two_pi * 0.05};
  out.sampling.sample_time = 1e-3;
  out.sampling.delay_samples = 1;
  return out;
}

/// What gains between l and g leave of a disk margin.
double disk_that_gains_allow(const GainRange& range) {
  return 2 * std::min((1 - range.lowest) / (1 + range.lowest),
                      std::isinf(range.highest) ? 1 : (range.highest - 1) / (range.highest + 1));
}

// A grid of 240 points a loop steps over this resonance, whose peak is 1e-4 of its frequency wide.
TEST(DiskMargin, OfANarrowResonanceIsNotSteppedOver) {
  for (double hz = 361; hz <= 369; hz += 1) {
    const LoopSettings loop = with_resonance(hz);
    const Margins found = margins(loop);
    // 1e-6: what the peak is proven to, and what gains are found to.
    EXPECT_LE(found.leg_disk(0), disk_that_gains_allow(found.leg_gain[0]) * (1 + 1e-5)) << hz;
    EXPECT_EQ(found.all_disk, found.leg_disk(0));
    // By hand: the resonance of the 0.3 kg alone, at points a hundredth of its width apart.
    const FromReturnRatio half(loop);
    double worst = 0;
    for (double f = hz; f < hz + 8; f += 1e-4)
      worst = worst_of(worst, std::abs(half(two_pi * f)(0, 0)));
    EXPECT_NEAR(found.leg_disk(0) * worst, 1, 1e-4) << hz;
  }
}

class RandomLoops : public testing::TestWithParam<unsigned> {
 protected:
  /// The first stable one from 1000 times the parameter on.
  static LoopSettings stable_loop() {
    for (unsigned seed = 1000 * GetParam();; ++seed) {
      LoopSettings loop = random_loop(seed);
      if (spectral_radius(loop) < largest_stable_radius) return loop;
    }
  }
};

TEST_P(RandomLoops, BothFormulationsAreOneSensitivity) {
  const LoopSettings loop = stable_loop();
  const LinearSystem half = half_sensitivity(loop);
  const FromReturnRatio other(loop);
  for (const double part : {0.003, 0.02, 0.1, 0.35, 0.9}) {
    const double angle = part * std::numbers::pi;
    MatrixXcd resolvent = -half.A.cast<Complex>();
    resolvent.diagonal().array() += std::polar(1.0, angle);
    const MatrixXcd Z = half.C * resolvent.partialPivLu().solve(half.B.cast<Complex>()) + half.D;
    // I + L cancels where a leg's loop is strong, some 100 at low frequencies.
    EXPECT_LT((Z - other(angle / loop.sampling.sample_time)).norm(), 1e-8 * Z.norm()) << part;
  }
}

TEST_P(RandomLoops, NoPeakIsHigherThanTheOneThatIsFound) {
  const LoopSettings loop = stable_loop();
  const double nyquist = std::numbers::pi / loop.sampling.sample_time;
  const FromReturnRatio half(loop);
  DiskSearch search(loop);
  for (Index leg = 0; leg < search.n_legs(); ++leg) {
    const DiskMargin found = search.of_leg(leg);
    ASSERT_TRUE(found.alpha > 0);
    EXPECT_NEAR(found.alpha * std::abs(half(two_pi * found.hz)(leg, leg)), 1, 1e-6);
    double worst = 0, where = 0;
    const auto look = [&](double omega) {
      const double value = std::abs(half(omega)(leg, leg));
      if (value > worst) where = omega;
      worst = worst_of(worst, value);
    };
    for (int i = 1; i <= 2000; ++i) {
      look(nyquist * i / 2000);
      look(nyquist * std::pow(10, -5.0 * i / 2000));
    }
    for (double step = nyquist / 4000; step > 1e-9 * nyquist; step /= 2) {
      const double centre = where;
      look(std::max(centre - step, 1e-9 * nyquist));
      look(std::min(centre + step, nyquist));
    }
    EXPECT_LE(worst * found.alpha, 1 + 2e-6) << leg;  // proven to 1e-6
  }
}

TEST_P(RandomLoops, JustInsideIsStableAndJustOutsideIsNot) {
  const LoopSettings loop = stable_loop();
  const LinearSystem half = half_sensitivity(loop);
  const FromReturnRatio Z(loop);
  DiskSearch search(loop);
  const Margins found = margins(loop);
  const Index m = search.n_legs();
  constexpr double pi = std::numbers::pi;
  Draws draw(GetParam());
  const VectorXcd ones = VectorXcd::Ones(m);
  for (Index leg = 0; leg < m; ++leg) {
    EXPECT_LE(found.all_disk, found.leg_disk(leg));
    const DiskMargin disk = search.of_leg(leg);
    VectorXcd factors = ones;
    // At the peak d Z = 1 closes the loop on the circle; a little more of it is outside.
    factors(leg) = factor((1 + 1e-3) / Z(two_pi * disk.hz)(leg, leg));
    EXPECT_GT(radius_with(half, factors), 1) << leg;
    for (int i = 0; i < 5; ++i) {
      factors(leg) = factor(std::polar((1 - 1e-3) * disk.alpha, draw.between(-pi, pi)));
      EXPECT_LT(radius_with(half, factors), 1) << leg;
    }
    GainRange range = found.leg_gain[static_cast<size_t>(leg)];
    for (double* edge : {&range.lowest, &range.highest}) {
      if (*edge == 0 || std::isinf(*edge)) continue;
      LoopSettings off = loop;
      const auto radius = [&](double gain) {
        off.sampling.leg_gains = VectorXd::Ones(m);
        off.sampling.leg_gains(leg) = gain;
        return spectral_radius(off);
      };
      const double outwards = *edge > 1 ? 1e-5 : -1e-5;
      EXPECT_LT(radius(*edge * (1 - outwards)), 1);
      EXPECT_GE(radius(*edge * (1 + outwards)), largest_stable_radius);
      // A pole that is too slow to be called stable ends the range as well, and no disk.
      if (radius(*edge * (1 + 100 * outwards)) < 1) *edge = *edge > 1 ? INFINITY : 0;
    }
    EXPECT_LE(found.leg_disk(leg), disk_that_gains_allow(range) * (1 + 1e-5));
  }
  for (int i = 0; i < 10; ++i) {
    const VectorXcd factors = VectorXcd::NullaryExpr(
        m, [&] { return factor(std::polar((1 - 1e-3) * found.all_disk, draw.between(-pi, pi))); });
    EXPECT_LT(radius_with(half, factors), 1);
  }
  EXPECT_NEAR(all_leg_disk_margin(loop, found.all_disk * 0.99).first, found.all_disk,
              1e-3 * found.all_disk);
  EXPECT_LT(all_leg_disk_margin(loop, found.all_disk * 1.01).first, found.all_disk * 1.01);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomLoops, testing::Range(1u, 41u));

// A leak of a millihertz at 20 kHz and modes without damping are poles within 1e-7 of the circle.
TEST(DiskMargin, StandsPolesNextToTheCircle) {
  LoopSettings loop = with_resonance(365);
  loop.feedback.leak = two_pi * 1e-3;
  loop.law.lead_samples = 1.5;
  loop.feedback.roll_off = two_pi * 320;
  loop = at_rate(loop, 20000);
  ASSERT_LT(spectral_radius(loop), largest_stable_radius);
  const Margins found = margins(loop);
  ASSERT_TRUE(found.all_disk > 0);
  EXPECT_LE(found.all_disk, disk_that_gains_allow(found.all_gain) * (1 + 1e-5));
}

TEST(DiskMargin, WhatIsNotFiniteIsNotKnownAndNotEnough) {
  LoopSettings loop = with_resonance(365);
  loop.feedback.K_P(0, 0) = std::nan("");
  EXPECT_FALSE(spectral_radius(loop) < largest_stable_radius);
  const MatrixXcd Z = MatrixXcd::Constant(2, 2, Complex(0.1, std::nan("")));
  EXPECT_TRUE(std::isnan(diagonal_mu(Z)));
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "core/mechanics/certificate.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/scene_text.hpp"

// The scenes of config/scenes/benchmarks: parameters and results that others have published, each
// against what its author prints and against a calculation by hand. Tolerances are half a unit of
// the last digit in print. Sources and differences: docs/benchmarks.md.
namespace stillframe::verification {
namespace {

using Complex = std::complex<double>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Largest distance from a root to its nearest computed neighbour.
double farthest(const std::vector<Complex>& roots, const Eigen::VectorXcd& computed) {
  double worst = 0;
  for (const Complex& root : roots)
    worst = worst_of(worst, (computed.array() - root).abs().minCoeff<Eigen::PropagateNaN>());
  return worst;
}

/// Poles with sigma_a = -g / (s + w_i) sigma from each force sensor to its own actuator.
Eigen::VectorXcd poles_of_force_feedback(const StateSpace& s, double g, double w_i) {
  const Eigen::Index n = s.A.rows(), m = s.B.cols();
  Eigen::MatrixXd A(n + m, n + m);
  A << s.A, -s.B, g * s.C, -g * s.D - w_i * Eigen::MatrixXd::Identity(m, m);
  return A.eigenvalues();
}

/// From the inputs to the outputs at f_hz; from a motion that is prescribed if there is one input,
/// which has the three columns of its acceleration, velocity and position.
Eigen::MatrixXcd response(const StateSpace& s, double f_hz, bool motion = false) {
  const Complex p(0, two_pi * f_hz);
  Eigen::MatrixXcd B = s.B, D = s.D;
  if (motion) {
    const Eigen::Vector3cd columns(p * p, p, 1);
    B = B * columns;
    D = D * columns;
  }
  Eigen::MatrixXcd pencil = -s.A.cast<Complex>();
  pencil.diagonal().array() += p;
  return s.C * pencil.lu().solve(B) + D;
}

TEST(Benchmarks, EveryBlockIsTheDerivativeOfTheNonlinearEquations) {
  for (const char* name : {"cubic_hexapod", "planar_platform", "quadruple_pendulum",
                           "rotating_force_feedback", "stewart_payload", "stewart_platform"}) {
    const std::string text = scene_text(std::string("benchmarks/") + name);
    for (const BlockCertificate& block : certify(parse_scene(text, name)))
      EXPECT_LE(block.difference, certified_difference) << name << ' ' << block.block;
  }
}

// Rotating force feedback. With z = u + j v on the table and P = s^2 + c s + k - W^2 + 2 j W s the
// plant is P z = F and the sensor has f = F - (c s + k_a) z, so that the loop has the roots of
//   (s + w_i) P + g (s^2 + 2 j W s - W^2 + k_p) = 0
// and their conjugates.
struct Rotating {
  double spin = 0.1, damping = 0.05, beside = 0;

  StateSpace model() const {
    std::string text = scene_text("benchmarks/rotating_force_feedback");
    text = with(text, "rate: 0.1", "rate: " + number(spin));
    text = with(text, "damping: 0.05", "damping: " + number(damping));
    text = with(text, "stiffness: 1,", "stiffness: " + number(1 - beside) + ",");
    text = with(text, "stiffness: 0}", "stiffness: " + number(beside) + "}");
    return state_space(linear_model(text));
  }
  std::vector<Complex> roots(double g, double w_i) const {
    const Complex coriolis(0, 2 * spin);
    const Complex p_1 = damping + coriolis, p_0 = 1 - spin * spin;
    Eigen::Matrix3cd companion = Eigen::Matrix3cd::Zero();
    companion(1, 0) = companion(2, 1) = 1;
    companion(0, 2) = -(w_i * p_0 + g * (beside - spin * spin));
    companion(1, 2) = -(p_0 + w_i * p_1 + g * coriolis);
    companion(2, 2) = -(p_1 + w_i + g);
    const Eigen::Vector3cd own =
        Eigen::ComplexEigenSolver<Eigen::Matrix3cd>(companion, false).eigenvalues();
    std::vector<Complex> all;
    for (const Complex& root : own) all.insert(all.end(), {root, std::conj(root)});
    return all;
  }
};

/// The largest damping ratio that the least damped pole can have, and the gain for it.
struct Best {
  double damping = 0, gain = 0;
};
Best best_damping(const StateSpace& model, double w_i) {
  Best best;
  for (int i = 100; i <= 400; ++i) {  // gains of 1 to 4, as fine as in print
    const double g = i / 100.;
    const Eigen::ArrayXcd poles = poles_of_force_feedback(model, g, w_i);
    const double least = (-poles.real() / poles.abs()).minCoeff<Eigen::PropagateNaN>();
    if (least > best.damping) best = {least, g};
  }
  return best;
}

TEST(Benchmarks, RotatingPlatformPoles) {
  for (const double spin : {0.0, 0.1, 0.5, 0.9}) {
    const Rotating platform{.spin = spin};
    const Eigen::VectorXcd poles = platform.model().A.eigenvalues();
    // (p + j W)^2 + c (p + j W) + 1 = c j W: by the quadratic.
    const Complex b(0.05, 2 * spin), root = std::sqrt(b * b - 4.0 * (1 - spin * spin));
    const Complex p_1 = (-b + root) / 2.0, p_2 = (-b - root) / 2.0;
    // Where the two pairs meet (no spin) rounding eps moves them by its square root.
    EXPECT_LE(farthest({p_1, p_2, std::conj(p_1), std::conj(p_2)}, poles), spin == 0 ? 1e-7 : 1e-13)
        << spin;
    // In print, to the first order in xi = 0.025; what is left out is below xi^2 / 2 at W = 0 and
    // grows as the lower pole comes down: xi^2 / 2 / (1 - W).
    const double xi = 0.025, left_out = xi * xi / 2 / (1 - spin);
    for (const double w : {1 + spin, 1 - spin})
      EXPECT_LE(farthest({Complex(-xi, 1) * w, Complex(-xi, -1) * w}, poles), 1.01 * left_out) << w;
  }
}

TEST(Benchmarks, RotatingForceSensorAtStandstill) {
  for (const double spin : {0.1, 0.5}) {
    const Eigen::MatrixXcd G = response(Rotating{.spin = spin}.model(), 0);
    EXPECT_NEAR(std::abs(G(0, 0)), spin * spin / (1 - spin * spin), 1e-13);
    EXPECT_LE(std::abs(G(0, 1)), 1e-13);
  }
}

TEST(Benchmarks, RotatingForceFeedbackHasALargestGain) {
  for (const double spin : {0.1, 0.2, 0.5}) {
    for (const double w_i : {0.01, 0.1, 0.5}) {
      const Rotating platform{.spin = spin};
      const StateSpace model = platform.model();
      const double g_max = w_i * (1 / (spin * spin) - 1);
      const auto growth = [&](double g) {
        const Eigen::VectorXcd poles = poles_of_force_feedback(model, g, w_i);
        EXPECT_LE(farthest(platform.roots(g, w_i), poles), 1e-12) << g;
        return poles.real().maxCoeff<Eigen::PropagateNaN>();
      };
      EXPECT_LT(growth(g_max * (1 - 1e-6)), 0) << spin << ' ' << w_i;
      EXPECT_GT(growth(g_max * (1 + 1e-6)), 0) << spin << ' ' << w_i;
      EXPECT_NEAR(growth(g_max), 0, 1e-13) << spin << ' ' << w_i;
    }
    // A pure integrator holds with no gain at all.
    const Eigen::VectorXcd poles = poles_of_force_feedback(Rotating{.spin = spin}.model(), 0.01, 0);
    EXPECT_GT(poles.real().maxCoeff<Eigen::PropagateNaN>(), 1e-5) << spin;
  }
}

TEST(Benchmarks, RotatingForceFeedbackWithParallelSpringsIsStableWithEveryGain) {
  const double spin = 0.1;
  for (const double ratio : {0.5, 0.999, 1.001, 5.0}) {  // k_p / (m W^2)
    const Rotating platform{.spin = spin, .beside = ratio * spin * spin};
    const StateSpace model = platform.model();
    for (const double g : {0.01, 0.1, 1.0, 10.0, 1e3, 1e5}) {
      const Eigen::VectorXcd poles = poles_of_force_feedback(model, g, 0);
      EXPECT_LE(farthest(platform.roots(g, 0), poles), 1e-13 * (1 + g)) << ratio << ' ' << g;
      // At a gain of 1e5 rounding is a tenth of the slowest real part.
      EXPECT_EQ(poles.real().maxCoeff<Eigen::PropagateNaN>() > 0, ratio < 1) << ratio << ' ' << g;
    }
  }
}

TEST(Benchmarks, RotatingForceFeedbackDampsAsWellEitherWay) {
  const Best filtered = best_damping(Rotating{}.model(), 0.1);
  EXPECT_NEAR(filtered.damping, 0.83, 0.005);  // both in print with two decimals
  EXPECT_NEAR(filtered.gain, 1.99, 0.005);
  const Best beside = best_damping(Rotating{.beside = 0.05}.model(), 0);
  EXPECT_NEAR(beside.damping, 0.83, 0.005);
  EXPECT_NEAR(beside.gain, 2.02, 0.005);
}

// The Stewart platform of stewart-simscape.

/// Joints of the toolbox: radius, height and angles of the feet and of the heads.
Eigen::Vector3d joint(bool head, int i) {
  const double foot_angles[] = {-10, 10, 110, 130, 230, 250};
  const double head_angles[] = {-50, 50, 70, 170, 190, 290};
  const double angle = (head ? head_angles : foot_angles)[i] * std::numbers::pi / 180;
  const double radius = head ? 0.09 : 0.115;
  return {radius * std::cos(angle), radius * std::sin(angle), head ? 0.075 : 0.015};
}

Eigen::Matrix3d cross(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return matrix;
}

/// What the six legs add to stiffness and mass of a body about a point on the axis at height z: a
/// leg is a spring and a mass along it, and turns about its foot across it.
struct Legs {
  Matrix6 stiffness = Matrix6::Zero(), mass = Matrix6::Zero();
};
Legs legs_about(double z, double along, double turning) {
  Legs legs;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d l = joint(true, i) - joint(false, i), s = l.normalized();
    Eigen::Matrix<double, 3, 6> motion;
    motion << Eigen::Matrix3d::Identity(), -cross(joint(true, i) - Eigen::Vector3d(0, 0, z));
    const Eigen::Matrix3d axial = s * s.transpose(), across = Eigen::Matrix3d::Identity() - axial;
    legs.stiffness += 2e7 * motion.transpose() * axial * motion;
    legs.mass += motion.transpose() * (along * axial + turning / l.squaredNorm() * across) * motion;
  }
  return legs;
}

Eigen::VectorXd hz_of(const Matrix6& stiffness, const Matrix6& mass) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> solver(stiffness, mass);
  return solver.eigenvalues().cwiseSqrt() / two_pi;
}

TEST(Benchmarks, StewartPlatformWithHeavyLegs) {
  const Modes result = modes(linear_model(scene_text("benchmarks/stewart_platform")));
  ASSERT_EQ(result.natural_frequencies_hz.size(), 6);
  const double in_print[] = {780.6, 780.6, 903.9, 1061.4, 1061.4, 1269.6};
  const double damping_in_print[] = {0.2, 0.2, 0.3, 0.3, 0.3, 0.4};  // %
  for (int i = 0; i < 6; ++i) {
    // The toolbox prints the imaginary parts. Half a unit of the last digit, but for the last one,
    // 1269.652 here, which rounds to 1269.7: 2 mHz more.
    const double f = std::abs(result.eigenvalues(2 * i).imag()) / two_pi;
    EXPECT_NEAR(f, in_print[i], i == 5 ? 0.053 : 0.05) << i;
    // Damping in proportion to stiffness, c / k = 1e-6 s.
    EXPECT_NEAR(result.damping_ratios(i),
                std::numbers::pi * 1e-6 * result.natural_frequencies_hz(i), 1e-9);
    EXPECT_NEAR(100 * result.damping_ratios(i), damping_in_print[i], 0.05) << i;
  }
  // By hand: rods of 0.1 kg, half a length from their joints.
  const double length = (joint(true, 0) - joint(false, 0)).norm();
  const double rod = 0.1 / 12 * (3 * std::pow(0.005, 2) + std::pow(0.05, 2));
  const double turning = 2 * rod + 0.1 * (std::pow(0.025, 2) + std::pow(length - 0.025, 2));
  const Legs legs = legs_about(0.085, 0.1, turning);
  Matrix6 mass = legs.mass;
  const double across = 1. / 12 * (3 * std::pow(0.1, 2) + std::pow(0.01, 2));
  mass.diagonal() += Eigen::Vector<double, 6>(1, 1, 1, across, across, 0.005);
  EXPECT_LE((result.natural_frequencies_hz - hz_of(legs.stiffness, mass)).cwiseAbs().maxCoeff(),
            1e-6);  // the scene has its joints with twelve digits and its inertias with nine
}

TEST(Benchmarks, StewartPlatformUnderAPayload) {
  const LinearModel model = linear_model(scene_text("benchmarks/stewart_payload"));
  const Eigen::VectorXd f = modes(model).natural_frequencies_hz;
  const double stated[] = {207.34, 207.34, 322.67, 322.67, 347.38, 385.18};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(f(i), stated[i], 0.005) << i;
  Matrix6 mass = Matrix6::Zero();
  mass.diagonal() << 10, 10, 10, 0.1, 0.1, 0.1;
  const Eigen::VectorXd by_hand = hz_of(legs_about(0.1, 0, 0).stiffness, mass);
  EXPECT_LE((f - by_hand).cwiseAbs().maxCoeff(), 1e-7);

  // Euler parameters are half the angles of a small rotation.
  Eigen::Vector<double, 6> half;
  half << 1, 1, 1, 0.5, 0.5, 0.5;
  const Matrix6 stiffness = half.asDiagonal() * model.stiffness() * half.asDiagonal();
  const Matrix6 compliance = stiffness.inverse();
  const Matrix6 compliance_by_hand = legs_about(0.135, 0, 0).stiffness.inverse();
  EXPECT_LE((compliance - compliance_by_hand).norm(), 1e-9 * compliance.norm());
  // In print with two digits: x and y, z, the angles, and between x and the angle about y.
  EXPECT_NEAR(compliance(0, 0), 4.7e-8, 0.05e-8);
  EXPECT_NEAR(compliance(1, 1), 4.7e-8, 0.05e-8);
  EXPECT_NEAR(compliance(2, 2), 2.1e-8, 0.05e-8);
  EXPECT_NEAR(compliance(3, 3), 5.2e-6, 0.05e-6);
  EXPECT_NEAR(compliance(4, 4), 5.2e-6, 0.05e-6);
  EXPECT_NEAR(compliance(5, 5), 1.7e-6, 0.05e-6);
  EXPECT_NEAR(compliance(0, 4), 3.2e-7, 0.05e-7);
  EXPECT_NEAR(compliance(1, 3), -3.2e-7, 0.05e-7);
}

// The cubic hexapod.

TEST(Benchmarks, CubicHexapodHasADiagonalStiffness) {
  const Eigen::VectorXd f =
      modes(linear_model(scene_text("benchmarks/cubic_hexapod"))).natural_frequencies_hz;
  // 2 k along every axis, 3/2 k h^2 and 6 k h^2 about them, h the height of the cube's part that
  // the legs use: 0.015 and 0.06 in print.
  const double h = 0.1;
  const double squares[] = {1.5 * h * h, 1.5 * h * h, 6 * h * h, 2, 2, 2};
  const double in_print[] = {0.015, 0.015, 0.06, 2, 2, 2};
  const double digit[] = {5e-4, 5e-4, 5e-3, 0.05, 0.05, 0.05};  // two digits, zeros left out
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(std::pow(two_pi * f(i), 2), squares[i], 1e-11) << i;
    EXPECT_NEAR(std::pow(two_pi * f(i), 2), in_print[i], digit[i]) << i;
  }
}

TEST(Benchmarks, CubicHexapodForceFeedbackDampsEveryModeAlike) {
  const StateSpace model = state_space(linear_model(scene_text("benchmarks/cubic_hexapod")));
  for (const double g : {0.01, 0.1, 1.0, 5.0}) {
    const Eigen::VectorXcd poles = poles_of_force_feedback(model, g, 0);
    for (const double square : {0.015, 0.06, 2.0}) {
      const Complex root = std::sqrt(Complex(g * g - 4 * square));
      // Modes that repeat, and at standstill an integrator for each leg: rounding by its root.
      EXPECT_LE(farthest({(-g + root) / 2.0, (-g - root) / 2.0}, poles), 1e-6) << g << square;
    }
    EXPECT_EQ((poles.array().abs() < 1e-6).count(), 6) << g;  // no static stiffness is left
  }
}

// The planar platform.

struct Planar {
  Eigen::Matrix3d J, M, K;
  Planar() {
    J << 1, 0, 1.7, 0, 1, -0.5, 0, 1, 0.5;
    M.setZero();
    M.diagonal() << 400, 400, 115;
    K = 15e3 * J.transpose() * J;
  }
  /// From the pushing forces of the struts to their lengths.
  Eigen::Matrix3cd plant(double f_hz) const {
    const Complex p(0, two_pi * f_hz);
    const Eigen::Matrix3cd dynamic = (p * p) * M + (1.0 + p * (20 / 15e3)) * K;
    return J * dynamic.inverse() * J.transpose();
  }
};

/// The largest coupling |G_ij| / sqrt(|G_ii G_jj|), which no scaling of a signal changes.
double coupling(const Eigen::Matrix3cd& G) {
  double worst = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double between = std::abs(G(i, j)) / std::sqrt(std::abs(G(i, i) * G(j, j)));
      if (i != j) worst = worst_of(worst, between);
    }
  }
  return worst;
}

TEST(Benchmarks, PlanarPlatformModes) {
  const LinearModel model = linear_model(scene_text("benchmarks/planar_platform"));
  const Modes result = modes(model);
  const double stated[] = {0.3613, 1.3783, 3.4669};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(result.natural_frequencies_hz(i), stated[i], 5e-5) << i;
  // y is alone; x and the angle are a quadratic.
  const double a = 15e3 / 400, b = 15e3 * (1.7 * 1.7 + 0.5) / 115, c = 15e3 * 1.7;
  const double root = std::sqrt(std::pow((a - b) / 2, 2) + c * c / (400 * 115));
  EXPECT_NEAR(result.natural_frequencies_hz(0), std::sqrt((a + b) / 2 - root) / two_pi, 1e-12);
  EXPECT_NEAR(result.natural_frequencies_hz(1), std::sqrt(2 * a) / two_pi, 1e-12);
  EXPECT_NEAR(result.natural_frequencies_hz(2), std::sqrt((a + b) / 2 + root) / two_pi, 1e-12);

  // The modal matrices, B_m = mu^-1 V^T J^T and C_m = J V with columns of V of unit length and any
  // sign, in the order of the author: the lowest mode, the highest, the vertical one.
  const Eigen::Matrix3d J = Planar().J;
  Eigen::Matrix3d B, C;
  const int order[] = {0, 2, 1};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d v = result.shapes.col(order[i]).normalized();
    const double sign = (i == 2 ? v(1) : -v(0)) > 0 ? 1 : -1;
    C.col(i) = sign * J * v;
    B.row(i) = C.col(i).transpose() / v.dot(model.M * v);
  }
  Eigen::Matrix3d B_in_print, C_in_print;
  B_in_print << -0.0004, -0.0007, 0.0007, -0.0151, 0.0041, -0.0041, 0, 0.0025, 0.0025;
  C_in_print << -0.1, -1.8, 0, -0.2, 0.5, 1, 0.2, -0.5, 1;
  EXPECT_LE((B - B_in_print).cwiseAbs().maxCoeff(), 5e-5) << B;
  EXPECT_LE((C - C_in_print).cwiseAbs().maxCoeff(), 0.05) << C;
}

TEST(Benchmarks, PlanarPlatformDecoupledInThreeWays) {
  const StateSpace model = state_space(linear_model(scene_text("benchmarks/planar_platform")));
  const Planar by_hand;
  // A positive sigma_a pulls, the author's struts push.
  const auto plant = [&](double f_hz) -> Eigen::Matrix3cd { return -response(model, f_hz); };
  for (const double f : {0.01, 0.2, 1.0, 10.0, 100.0})
    EXPECT_LE((plant(f) - by_hand.plant(f)).norm(), 1e-11 * by_hand.plant(f).norm()) << f;

  // At 10 Hz in print with two digits, made real; damping turns it by less than those.
  Eigen::Matrix3d in_print;
  in_print << -8e-6, 2.1e-6, -2.1e-6, 2.1e-6, -1.3e-6, -2.5e-8, -2.1e-6, -2.5e-8, -1.3e-6;
  Eigen::Matrix3d digit;
  digit << 0.5e-7, 0.5e-7, 0.5e-7, 0.5e-7, 0.5e-7, 0.5e-9, 0.5e-7, 0.5e-9, 0.5e-7;
  const Eigen::Matrix3d real = plant(10).real();
  EXPECT_TRUE(((real - in_print).array().abs() <= digit.array()).all()) << real;

  // The Jacobian of the centre of mass decouples above the modes, modal matrices everywhere, and so
  // do singular vectors here: with struts of one stiffness G^-1 = s^2 J^-T M J^-1 + (k + c s) I, a
  // function of one symmetric matrix.
  const Eigen::Matrix3d to_body = by_hand.J.inverse();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(real, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Modes own = modes(linear_model(scene_text("benchmarks/planar_platform")));
  const Eigen::Matrix3d to_modes = (by_hand.J * own.shapes).inverse();
  for (const double f : {0.01, 0.2, 1.0, 10.0, 100.0}) {
    const Eigen::Matrix3cd G = plant(f);
    EXPECT_LE(coupling(to_modes * G * to_modes.transpose()), 1e-10) << f;
    EXPECT_LE(coupling(svd.matrixU().transpose() * G * svd.matrixV()), 1e-10) << f;
  }
  const auto about_the_centre = [&](double f) {
    return coupling(to_body * plant(f) * to_body.transpose());
  };
  // At standstill of the stiffness alone, far above the modes of k + c s over the masses.
  EXPECT_NEAR(about_the_centre(1e-4), 1.7 / std::sqrt(1.7 * 1.7 + 0.5), 1e-6);
  const double w = two_pi * 1000, high = std::abs(Complex(15e3, 20 * w)) * 1.7;
  EXPECT_NEAR(about_the_centre(1000) * w * w * std::sqrt(400. * 115) / high, 1, 1e-4);
  EXPECT_GT(about_the_centre(1), 1);  // between the modes what couples is the larger part
}

// The quadruple pendulum.

/// Point masses on wires, the first one below the table: stiffness along x under gravity.
struct Pendulum {
  Eigen::Vector4d mass, length;
  double gravity = 9.80665;

  Eigen::Vector4d springs() const {
    Eigen::Vector4d k;
    for (int i = 0; i < 4; ++i) k(i) = gravity * mass.tail(4 - i).sum() / length(i);
    return k;
  }
  Eigen::Matrix4d stiffness() const {
    const Eigen::Vector4d k = springs();
    Eigen::Matrix4d K = k.asDiagonal();
    for (int i = 0; i < 3; ++i) {
      K(i, i) += k(i + 1);
      K(i, i + 1) = K(i + 1, i) = -k(i + 1);
    }
    return K;
  }
  Eigen::Vector4d frequencies_hz() const {
    const Eigen::Matrix4d M = mass.asDiagonal();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix4d> solver(stiffness(), M);
    return solver.eigenvalues().cwiseSqrt() / two_pi;
  }
  double to_mirror(double f_hz) const {
    Eigen::Matrix4d dynamic = stiffness();
    dynamic.diagonal() -= std::pow(two_pi * f_hz, 2) * mass;
    return dynamic.lu().solve(Eigen::Vector4d(springs()(0), 0, 0, 0))(3);
  }
  /// The scene with these masses and lengths.
  std::string text() const {
    std::string scene = scene_text("benchmarks/quadruple_pendulum");
    const char* heights[] = {"-0.416", "-0.693", "-1.034", "-1.624"};
    const char* nodes[] = {"top", "upper_intermediate", "penultimate", "mirror"};
    const char* masses[] = {"22.1", "21.8", "39.6", "39.6"};
    for (int i = 0; i < 4; ++i) {
      scene = with(scene, heights[i], number(-length.head(i + 1).sum()));
      scene = with(scene, std::string("node: ") + nodes[i] + ", mass: " + masses[i],
                   std::string("node: ") + nodes[i] + ", mass: " + number(mass(i)));
    }
    return scene;
  }
};

TEST(Benchmarks, QuadruplePendulum) {
  const Pendulum chain{{22.1, 21.8, 39.6, 39.6}, {0.416, 0.277, 0.341, 0.59}};
  const LinearModel model = linear_model(scene_text("benchmarks/quadruple_pendulum"));
  const Eigen::VectorXd f = modes(model).natural_frequencies_hz;
  EXPECT_LE((f - chain.frequencies_hz()).cwiseAbs().maxCoeff(), 1e-12);
  const StateSpace s = state_space(model);
  for (const double hz : {0.1, 0.7, 1.5, 5.0, 10.0, 20.0}) {
    const double T = response(s, hz, true)(0, 0).real();
    EXPECT_NEAR(T, chain.to_mirror(hz), 1e-9 * std::abs(T)) << hz;
  }
  // pygwinc, run with its own file, has fibres that bend: 1.0200e-7 at 10 Hz, 1.2 % more.
  EXPECT_NEAR(std::abs(response(s, 10, true)(0, 0)), 1.0200e-7, 0.013 * 1.02e-7);
  // The poles of LIGO's own model along the beam, which has masses and lengths that differ by up
  // to 1.5 % (next test).
  const double theirs[] = {0.44040, 0.99114, 1.97985, 3.39564};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(f(i), theirs[i], 0.004 * theirs[i]) << i;
}

TEST(Benchmarks, QuadruplePendulumOfLigo) {
  // simple_long_quadmodel.mat of LIGO-Controls-Problems: accelerations of the four masses from
  // their positions, and from the table's to the first mass.
  Eigen::Matrix4d A;
  A << -294.937707, 164.746633, 0, 0,         //
      164.746633, -269.742924, 104.99629, 0,  //
      0, 58.219538, -74.956238, 16.7367,      //
      0, 0, 16.751477, -16.751477;
  const Eigen::Vector4d B(130.191073, 0, 0, 0);
  Eigen::Vector4d poles = (-A).eigenvalues().real().cwiseSqrt() / two_pi;
  std::sort(poles.begin(), poles.end());

  Pendulum chain{{22, 22, 39.676, 39.641}, {}};
  const Eigen::Vector4d k(B(0) * 22, A(0, 1) * 22, A(1, 2) * 22, A(3, 2) * 39.641);
  chain.length.setOnes();
  chain.length = chain.springs().cwiseQuotient(k);
  const LinearModel model = linear_model(chain.text());
  const Eigen::VectorXd f = modes(model).natural_frequencies_hz;
  // The matrix was read with eight digits or more.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(f(i), poles(i), 1e-7) << i;
  const StateSpace s = state_space(model);
  for (const double hz : {0.1, 1.0, 10.0}) {
    Eigen::Matrix4d dynamic = -A;
    dynamic.diagonal().array() -= std::pow(two_pi * hz, 2);
    const double T = dynamic.lu().solve(B)(3);
    EXPECT_NEAR(response(s, hz, true)(0, 0).real(), T, 1e-6 * std::abs(T)) << hz;
  }
}

}  // namespace
}  // namespace stillframe::verification

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/integrator.hpp"
#include "tests/verification/scene_text.hpp"

// V13: a free body that spins about its intermediate axis and turns over again and again.
namespace stillframe::verification {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

const Vector3d principal(1, 2, 3);           // kg m^2, of the scene
const Vector3d initial_spin(1e-3, 1, 1e-3);  // rad/s, of the scene

Matrix3d rotation(const Vector4d& l) {
  const Vector3d v = l.tail<3>();
  Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Matrix3d::Identity() + 2 * l(0) * cross + 2 * cross * cross;
}

/// The body in a scene drawn as it stands: q^d = (x, y, z, lambda_1, lambda_2, lambda_3) is good
/// for less than half a turn from there, so that after 0.8 rad the scene is drawn anew.
class Body {
 public:
  Body()
      : scene_(parse_scene(scene_text("free_body"), "free_body")), attitude_(Matrix3d::Identity()) {
    Vector3d velocity;
    for (int i = 0; i < 3; ++i) velocity(i) = scene_.dofs[static_cast<size_t>(i)].rate;
    for (SceneDof& dof : scene_.dofs) dof.rate = 0;
    draw(Vector3d::Zero(), velocity, initial_spin);
  }

  void advance(double duration, double tolerance) {
    Integrator integrator(
        6,
        [this](double, const Eigen::Ref<const VectorXd>& y, Eigen::Ref<VectorXd> dy_dt) {
          return rate(y, dy_dt);
        },
        tolerance);
    ASSERT_EQ(integrator.advance(y_, duration, 0.1, duration), Integrator::Status::ok);
    VectorXd dy_dt(12);
    ASSERT_TRUE(rate(y_, dy_dt));
    if (std::abs(lambda()(0)) < std::cos(0.4)) {
      const Vector3d position = y_.head<3>(), velocity = y_.segment<3>(6), w = spin();
      attitude_ = rotation(lambda()) * attitude_;
      draw(position, velocity, w);
      ++charts_;
    }
  }

  /// Euler parameters from the latest drawing, and their rates.
  Vector4d lambda() const { return Vector4d::Unit(0) + coordinates(data_->x); }
  /// Angular velocity in space, 2 (l_0 l' - l_0' l + l x l').
  Vector3d spin() const {
    const Vector4d l = lambda(), r = coordinates(data_->x_dot);
    const Vector3d v = l.tail<3>(), v_dot = r.tail<3>();
    return 2 * (l(0) * v_dot - r(0) * v + v.cross(v_dot));
  }
  Vector3d spin_in_body() const { return attitude().transpose() * spin(); }
  Vector3d momentum() const { return attitude() * principal.cwiseProduct(spin_in_body()); }
  double energy() const { return kinetic_energy(*model_, *data_); }
  Vector3d position() const { return y_.head<3>(); }
  int charts() const { return charts_; }

 private:
  Matrix3d attitude() const { return rotation(lambda()) * attitude_; }

  Vector4d coordinates(const VectorXd& x) const {
    Vector4d result;
    const PartMap& part = model_->nodes.front().rotation;
    for (size_t i = 0; i < 4; ++i) result(static_cast<Eigen::Index>(i)) = x(part.column[i]);
    return result;
  }

  bool rate(const Eigen::Ref<const VectorXd>& y, Eigen::Ref<VectorXd> dy_dt) {
    state_->q_d = y.head(6);
    state_->q_d_dot = y.tail(6);
    if (accelerations(*model_, *data_, *state_, VectorXd::Zero(model_->n_e), q_d_ddot_) !=
        DynamicsStatus::ok) {
      return false;
    }
    dy_dt << y.tail(6), q_d_ddot_;
    return true;
  }

  void draw(const Vector3d& position, const Vector3d& velocity, const Vector3d& w) {
    scene_.masses.front().inertia = attitude_ * principal.asDiagonal() * attitude_.transpose();
    model_.emplace(make_model(scene_));
    data_.emplace(*model_);
    state_.emplace(*model_);
    y_.resize(12);
    y_ << position, Vector3d::Zero(), velocity, w / 2;
    q_d_ddot_.resize(6);
    VectorXd dy_dt(12);
    rate(y_, dy_dt);
  }

  Scene scene_;
  Matrix3d attitude_;  ///< of the latest drawing against the first
  std::optional<Model> model_;
  std::optional<Data> data_;
  std::optional<MotionState> state_;
  VectorXd y_, q_d_ddot_;
  int charts_ = 0;
};

/// Euler's equations in closed form for L^2 > 2 E I_2: amplitudes times (cn, sn, dn) of u + p t.
/// Jacobi's functions by the arithmetic-geometric mean (Abramowitz and Stegun, 16.4).
class ClosedForm {
 public:
  ClosedForm() {
    const Vector3d& I = principal;
    const Vector3d& w = initial_spin;
    const double E2 = I.dot(w.cwiseAbs2()), L2 = I.cwiseProduct(w).squaredNorm();
    const double above = L2 - E2 * I(0), below = E2 * I(2) - L2;
    amplitudes_ << std::sqrt(below / (I(0) * (I(2) - I(0)))),
        std::sqrt(below / (I(1) * (I(2) - I(1)))), std::sqrt(above / (I(2) * (I(2) - I(0))));
    rate_ = std::sqrt((I(2) - I(1)) * above / I.prod());
    modulus_squared_ = (I(1) - I(0)) * below / ((I(2) - I(1)) * above);
    // tan am from sn / cn: sn is near 1, where its inverse loses half of the digits.
    start_ = std::ellint_1(std::sqrt(modulus_squared_),
                           std::atan2(w(1) / amplitudes_(1), w(0) / amplitudes_(0)));
  }

  double period() const { return 4 * std::comp_ellint_1(std::sqrt(modulus_squared_)) / rate_; }

  Vector3d spin(double t) const {
    std::vector<double> a{1}, c{std::sqrt(modulus_squared_)};
    for (double b = std::sqrt(1 - modulus_squared_); std::abs(c.back()) > 1e-17;) {
      const double mean = (a.back() + b) / 2;
      c.push_back((a.back() - b) / 2);
      b = std::sqrt(a.back() * b);
      a.push_back(mean);
    }
    double phi = std::ldexp(a.back() * (start_ + rate_ * t), static_cast<int>(a.size()) - 1);
    for (size_t i = a.size() - 1; i > 0; --i)
      phi = (phi + std::asin(c[i] * std::sin(phi) / a[i])) / 2;
    const double sn = std::sin(phi), dn = std::sqrt(1 - modulus_squared_ * sn * sn);
    return amplitudes_.cwiseProduct(Vector3d(std::cos(phi), sn, dn));
  }

 private:
  Vector3d amplitudes_;
  double rate_ = 0, modulus_squared_ = 0, start_ = 0;
};

struct Drift {
  double energy = 0, momentum = 0, norm = 0, spin = 0, path = 0;
  int charts = 0, tumbles = 0;
};

Drift drift_over(double duration, double tolerance) {
  Body body;
  const ClosedForm closed_form;
  const double energy = body.energy(), step = 0.25;
  const Vector3d momentum = body.momentum();
  Drift worst;
  double side = 1;
  for (int i = 1; i * step <= duration; ++i) {
    body.advance(step, tolerance);
    worst.energy = worst_of(worst.energy, std::abs(body.energy() / energy - 1));
    worst.momentum =
        worst_of(worst.momentum, (body.momentum() - momentum).norm() / momentum.norm());
    worst.norm = worst_of(worst.norm, std::abs(body.lambda().squaredNorm() - 1));
    worst.path = worst_of(worst.path, (body.position() - Vector3d(0.1 * i * step, 0, 0)).norm());
    const Vector3d spin = body.spin_in_body();
    worst.spin = worst_of(worst.spin, (spin - closed_form.spin(i * step)).norm());
    if (spin.y() * side < -0.5) {
      side = -side;
      ++worst.tumbles;
    }
  }
  worst.charts = body.charts();
  return worst;
}

TEST(V13, ClosedFormStartsWhereTheSceneDoesAndSolvesEulersEquations) {
  const ClosedForm closed_form;
  EXPECT_LE((closed_form.spin(0) - initial_spin).norm(), 1e-12);
  for (const double t : {0.0, 11.0, 14.5, 40.0}) {
    const double h = 1e-3;  // differences of the order h^4, and rounding of 1e-14 / h
    const Vector3d w = closed_form.spin(t);
    const Vector3d rate = (8 * (closed_form.spin(t + h) - closed_form.spin(t - h)) -
                           (closed_form.spin(t + 2 * h) - closed_form.spin(t - 2 * h))) /
                          (12 * h);
    const Vector3d moment = principal.cwiseProduct(rate) + w.cross(principal.cwiseProduct(w));
    EXPECT_LE(moment.norm(), 1e-10) << t;
  }
}

TEST(V13, EnergyAndMomentumAreKeptToTheToleranceOfTheIntegrator) {
  const double duration = 5 * ClosedForm().period();
  double previous = 0;
  for (const double tolerance : {1e-8, 1e-10, 1e-12}) {
    const Drift drift = drift_over(duration, tolerance);
    std::cout << "V13: " << drift.tumbles << " turns over in " << duration << " s, tolerance "
              << tolerance << ": energy " << drift.energy << ", momentum " << drift.momentum
              << ", norm " << drift.norm << ", spin " << drift.spin
              << " rad/s from the closed form, " << drift.charts << " drawings\n";
    EXPECT_EQ(drift.tumbles, 10);
    // Some 1e3 steps, whose errors are each up to the tolerance, add up.
    EXPECT_LE(drift.energy, 1e3 * tolerance);
    EXPECT_LE(drift.momentum, 1e3 * tolerance);
    EXPECT_LE(drift.norm, 1e-15 * 4);  // lambda_0 is solved for by Newton's method, to rounding
    EXPECT_LE(drift.path, 1e3 * tolerance * 0.1 * duration);
    if (previous > 0) {
      EXPECT_LT(drift.energy, previous / 10) << "the drift follows the tolerance";
    }
    previous = drift.energy;
  }
}

/// The time between two turns goes as the logarithm of the distance from the separatrix, 1e-6 here,
/// so that an error of energy or momentum of 1e-14 makes 1e-8 of a period.
TEST(V13, SpinIsThatOfJacobisEllipticFunctions) {
  const double period = ClosedForm().period();
  const Drift drift = drift_over(2 * period, 1e-13);
  std::cout << "V13: period " << period << " s, tolerance 1e-13: spin within " << drift.spin
            << " rad/s of the closed form over two periods, energy " << drift.energy << "\n";
  EXPECT_EQ(drift.tumbles, 4);
  EXPECT_LE(drift.spin, 1e-6);
}

}  // namespace
}  // namespace stillframe::verification

#include "tests/plant_sim/linear_plant.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"

namespace stillframe::test {

namespace {

/// z in micrometres keeps the entries of the exponential within a few orders of magnitude.
constexpr double unit_of_z = 1e-6;

LoopPlant linear(const Scene& scene, const Model& model) {
  std::vector<SceneSignal> inputs = scene.inputs, outputs = scene.outputs;
  for (const std::string& leg : scene.controller->legs) {
    SceneSignal signal;
    signal.element = leg;
    signal.quantity = Quantity::stress;
    inputs.push_back(signal);
    outputs.push_back(signal);
  }
  const LinearModel about = linearise(model, solve_equilibrium(model).motion, inputs, outputs);
  return loop_plant(about, static_cast<Index>(scene.inputs.size()),
                    static_cast<Index>(scene.outputs.size()));
}

}  // namespace

LinearPlant::LinearPlant(const Scene& scene, const Model& model)
    : instruments_(scene.instruments),
      limit_(scene.controller->force_limit_n.value_or(std::numeric_limits<double>::infinity())),
      sample_time_(1 / scene.controller->sample_rate_hz) {
  const LoopPlant plant = linear(scene, model);
  n_z_ = plant.A.rows();
  m_ = plant.B_u.cols();
  n_y_ = plant.C_y.rows();
  const Index f = n_z_, s = f + m_, y = s + m_, w = y + n_y_, n_w = plant.B_w.cols(), c = w + n_w;
  const double omega_a = 2 * std::numbers::pi * instruments_.actuator_lag_hz;
  const double omega_s = 2 * std::numbers::pi * instruments_.sensor_filter_hz;
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(m_, m_);
  // Without lag the command itself acts.
  const Index acting = omega_a > 0 ? f : c;
  C_sigma_ = plant.C_sigma * unit_of_z;
  F_ = Eigen::MatrixXd::Zero(c + m_, c + m_);
  F_.block(0, 0, n_z_, n_z_) = plant.A;
  F_.block(0, w, n_z_, n_w) = plant.B_w / unit_of_z;
  F_.block(0, acting, n_z_, m_) = plant.B_u * instruments_.actuator_gain / unit_of_z;
  F_.block(f, f, m_, m_) = -omega_a * I;
  F_.block(f, c, m_, m_) = omega_a * I;
  F_.block(s, 0, m_, n_z_) = omega_s * C_sigma_;
  F_.block(s, acting, m_, m_) = omega_s * instruments_.actuator_gain * I;
  F_.block(s, s, m_, m_) = -omega_s * I;
  F_.block(y, 0, n_y_, n_z_) = plant.C_y * unit_of_z;
  F_.block(y, w, n_y_, n_w) = plant.D_yw;
  F_.block(y, acting, n_y_, m_) = plant.D_yu * instruments_.actuator_gain;
  X_ = Eigen::VectorXd::Zero(w);
  mean_ = Eigen::VectorXd::Zero(n_y_);
  w_ = Eigen::VectorXd::Zero(n_w);
  c_ = Eigen::VectorXd::Zero(m_);
  reports_.push_back(c_);
}

void LinearPlant::hold(const Eigen::VectorXd& command, double duration, const Eigen::VectorXd& w) {
  w_ = w;
  c_ = command.unaryExpr(
      [this](double u) { return std::abs(u) > limit_ ? (u > 0 ? limit_ : -limit_) : u; });
  Eigen::VectorXd all(F_.rows());
  all << X_, w_, c_;
  Eigen::MatrixXd& step = steps_[duration];
  if (step.size() == 0) step = (F_ * duration).exp();
  X_ = (step * all).head(X_.size());
}

void LinearPlant::advance(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                          double fraction, const Eigen::VectorXd& w) {
  X_.tail(n_y_).setZero();
  if (fraction > 0) hold(before, fraction * sample_time_, w);
  hold(after, (1 - fraction) * sample_time_, w);
  mean_ = X_.tail(n_y_) / sample_time_;
  const bool lag = instruments_.actuator_lag_hz > 0;
  const bool measured = instruments_.report == Instruments::Report::measured;
  reports_.push_back(lag && measured ? X_.segment(n_z_, m_).eval() : c_);
}

Reading LinearPlant::read() const {
  const bool lag = instruments_.actuator_lag_hz > 0;
  const Eigen::VectorXd force = lag ? X_.segment(n_z_, m_).eval() : c_;
  const Index k = static_cast<Index>(reports_.size()) - 1 - instruments_.report_age_samples;
  return {
      .floor_acceleration = w_,
      .sigma = instruments_.sensor_filter_hz > 0
                   ? X_.segment(n_z_ + m_, m_).eval()
                   : (C_sigma_ * X_.head(n_z_) + instruments_.actuator_gain * force).eval(),
      .applied_force = k < 0 ? Eigen::VectorXd::Zero(m_).eval() : reports_[static_cast<size_t>(k)],
      .frame_acceleration = mean_};
}

}  // namespace stillframe::test

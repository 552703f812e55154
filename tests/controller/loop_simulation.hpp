#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "controller/law.hpp"
#include "core/control/discrete_law.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller::toy {

/// What may be wrong between the command and the legs.
struct Imperfections {
  double actuator_gain = 1;  ///< of the force that really acts, against the one that is reported
  double actuator_lag_hz =
      0;                  ///< first-order lag of the force, 0 means none; the report follows it
  int stale_samples = 0;  ///< age of the applied force in the measurement
};

/// The toy plant and a law, stepped sample by sample in closed form (each mode a rotation about its
/// static position): a second way to the sampled loop, free of matrix exponentials and of
/// close_loop.
class LoopSimulation {
 public:
  LoopSimulation(const Gains& gains, DiscreteLaw law, int delay, Imperfections imperfections = {})
      : T_(gains.sample_time()), law_(std::move(law)), delay_(delay), imperfect_(imperfections) {
    m_ = gains.n_legs();
    state_ =
        Eigen::VectorXd::Zero(2 * m_ + law_.A.rows() + m_ * (2 + delay + imperfect_.stale_samples));
  }

  Eigen::Index size() const { return state_.size(); }
  Eigen::VectorXd& state() { return state_; }

  /// From one sample to the next. State: [q, q' | law | force in the leg | reports | pending
  /// commands].
  void step() {
    Eigen::VectorXd& s = state_;
    const Eigen::Index n_law = law_.A.rows(), i_force = 2 * m_ + n_law, i_report = i_force + m_;
    const Eigen::Index n_report = m_ * (1 + imperfect_.stale_samples),
                       i_pending = i_report + n_report;
    Eigen::VectorXd e(m_);
    for (Eigen::Index i = 0; i < m_; ++i) {
      e(i) = stiffness(i) * s(i) + s(i_force + i);
    }
    // Reports are held oldest first.
    if (law_.subtract_applied) e -= s.segment(i_report, m_);
    const Eigen::VectorXd x = s.segment(2 * m_, n_law);
    const Eigen::VectorXd u = law_.C * x + law_.D * e;
    s.segment(2 * m_, n_law) = law_.A * x + law_.B * e;
    Eigen::VectorXd commanded = u;
    if (delay_ > 0) {
      commanded = s.segment(i_pending, m_);
      shift_in(i_pending, m_ * delay_, u);
    }
    const Eigen::VectorXd held = lagged(commanded, i_force);
    for (Eigen::Index i = 0; i < m_; ++i) {
      move(static_cast<size_t>(i), s(i), s(m_ + i), imperfect_.actuator_gain * held(i), T_);
    }
    s.segment(i_force, m_) = imperfect_.actuator_gain * held;
    shift_in(i_report, n_report, held);
  }

 private:
  static double stiffness(Eigen::Index i) {
    return std::pow(two_pi * frequencies_hz()[static_cast<size_t>(i)], 2);
  }

  Eigen::VectorXd lagged(const Eigen::VectorXd& commanded, Eigen::Index i_force) const {
    if (imperfect_.actuator_lag_hz <= 0) return commanded;
    const double a = std::exp(-two_pi * imperfect_.actuator_lag_hz * T_);
    return a * state_.segment(i_force, m_) / imperfect_.actuator_gain + (1 - a) * commanded;
  }

  void shift_in(Eigen::Index begin, Eigen::Index length, const Eigen::VectorXd& newest) {
    for (Eigen::Index i = begin; i + m_ < begin + length; ++i) state_(i) = state_(i + m_);
    state_.segment(begin + length - m_, m_) = newest;
  }

  double T_;
  DiscreteLaw law_;
  int delay_;
  Imperfections imperfect_;
  Eigen::Index m_ = 0;
  Eigen::VectorXd state_;
};

/// The matrix of one step, column by column.
inline Eigen::MatrixXd step_matrix(LoopSimulation loop) {
  Eigen::MatrixXd A(loop.size(), loop.size());
  for (Eigen::Index i = 0; i < loop.size(); ++i) {
    loop.state() = Eigen::VectorXd::Unit(loop.size(), i);
    loop.step();
    A.col(i) = loop.state();
  }
  return A;
}

}  // namespace stillframe::controller::toy

#include "judge/loop_target.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/numerics/two_pi.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;

std::optional<LoopTarget> target_of(const LoopDesign& design) {
  const LinearModel& plant = design.loop.plant;
  const Index n = design.loop.n_legs;
  if (plant.M.rows() != n) return std::nullopt;
  // The elongations of the legs are e = E q: the dofs may be others.
  const MatrixXd E = -plant.B.rightCols(n).transpose();
  const Eigen::FullPivLU<MatrixXd> lu(E);
  if (!lu.isInvertible()) return std::nullopt;
  const MatrixXd inverse = lu.inverse();
  const MatrixXd M = inverse.transpose() * plant.M * inverse;
  const MatrixXd K = inverse.transpose() * plant.stiffness() * inverse;
  const MatrixXd X = MatrixXd::Identity(n, n) + design.loop.gains.K_P;
  // K M^-1 = omega_d^2 X: one number for all entries.
  const MatrixXd KM = M.transpose().partialPivLu().solve(K.transpose()).transpose();
  const double omega_squared = (X.array() * KM.array()).sum() / X.squaredNorm();
  const double damping = (X.array() * design.loop.gains.K_I.array()).sum() / X.squaredNorm();
  constexpr double same = 1e-6;
  if (!(omega_squared > 0) || !((KM - omega_squared * X).norm() <= same * KM.norm()) ||
      !((design.loop.gains.K_I - damping * X).norm() <= same * damping * X.norm())) {
    return std::nullopt;
  }
  const double omega = std::sqrt(omega_squared);
  return LoopTarget{.frequency_hz = omega / two_pi, .damping_ratio = damping / (2 * omega)};
}

FrequencyRange axis_of(const LoopDesign& design) {
  std::vector<double> targets_hz = design.gains.target_hz;
  const auto target = targets_hz.empty() ? target_of(design) : std::nullopt;
  if (target) targets_hz.push_back(target->frequency_hz);
  return axis_of(design, targets_hz);
}

}  // namespace stillframe::judge

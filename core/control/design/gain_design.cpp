#include "core/control/design/gain_design.hpp"

#include <stdexcept>
#include <string>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/positive_definite.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void require_targets(const std::vector<ModeTarget>& targets, Index r) {
  const size_t count = targets.size();
  if (count != 1 && static_cast<Index>(count) != r) {
    throw std::invalid_argument("gain design: expected one target or " + std::to_string(r) +
                                ", got " + std::to_string(count));
  }
  for (const ModeTarget& target : targets) {
    if (target.omega_d > 0 && target.zeta > 0) continue;
    throw std::invalid_argument("gain design: expected targets above zero, got omega_d = " +
                                std::to_string(target.omega_d) +
                                ", zeta = " + std::to_string(target.zeta));
  }
}

void require_determined_modes(const VirtualModes& modes, const std::vector<ModeTarget>& targets) {
  const VectorXd omega = modes.squares.cast<double>().cwiseSqrt();
  for (Index i = 0; i + 1 < omega.size(); ++i) {
    const ModeTarget &a = targets[static_cast<size_t>(i)], &b = targets[static_cast<size_t>(i + 1)];
    if (a.omega_d == b.omega_d && a.zeta == b.zeta) continue;
    if (omega(i + 1) - omega(i) > same_frequency * omega(i + 1)) continue;
    throw Refusal(
        formatted("virtual modes %td and %td are of one frequency, %.6g Hz, so that their shapes "
                  "are not determined: give them the same target",
                  i + 1, i + 2, omega(i) / two_pi));
  }
}

GainDesign with_one_target(const LegMatrices& legs, const ModeTarget& target) {
  require_stiffness(legs.K);
  const ExtendedMatrix L = mass_factor(legs.M);
  // K M^-1 = (M^-1 K)^T as both matrices are symmetric.
  const ExtendedMatrix K_M_inverse =
      backward_solve(L, forward_solve(L, extended(legs.K))).transpose();
  const DoubleDouble omega = target.omega_d;
  return {.X = K_M_inverse / (omega * omega),
          .K_I = K_M_inverse * (2 * DoubleDouble(target.zeta) / omega)};
}

GainDesign with_a_target_each(const LegMatrices& legs, const std::vector<ModeTarget>& targets) {
  const VirtualModes modes = virtual_modes(legs, targets);
  ExtendedVector of_X(modes.squares.size()), of_K_I(modes.squares.size());
  for (Index i = 0; i < of_X.size(); ++i) {
    const auto& [omega_d, zeta] = targets[static_cast<size_t>(i)];
    const DoubleDouble omega = omega_d;
    of_X(i) = 1 / (omega * omega);
    of_K_I(i) = 2 * DoubleDouble(zeta) / omega;
  }
  const ExtendedMatrix K_Phi = extended(legs.K) * modes.Phi;
  return {.X = K_Phi * of_X.asDiagonal() * modes.Phi.transpose(),
          .K_I = K_Phi * of_K_I.asDiagonal() * modes.Phi.transpose()};
}

ExtendedMatrix without_one(const ExtendedMatrix& X) {
  return X - ExtendedMatrix::Identity(X.rows(), X.cols());
}

}  // namespace

VirtualModes virtual_modes(const LegMatrices& legs, const std::vector<ModeTarget>& targets) {
  require_targets(targets, legs.M.rows());
  require_stiffness(legs.K);
  const ExtendedMatrix L = mass_factor(legs.M);
  const ExtendedMatrix half = forward_solve(L, extended(legs.K));
  const SymmetricEigen modes = symmetric_eigen(forward_solve(L, half.transpose()));
  VirtualModes found{.squares = modes.values, .Phi = backward_solve(L, modes.V)};
  if (targets.size() > 1) require_determined_modes(found, targets);
  return found;
}

ForceFeedback GainDesign::gains() const {
  return {.K_P = rounded(without_one(X)), .K_I = rounded(K_I)};
}

GainDesign extended_gains(const LegMatrices& legs, const std::vector<ModeTarget>& targets,
                          GainOrder order) {
  require_targets(targets, legs.M.rows());
  GainDesign design = targets.size() == 1 ? with_one_target(legs, targets.front())
                                          : with_a_target_each(legs, targets);
  if (order == GainOrder::deck) {
    design.X.transposeInPlace();
    design.K_I.transposeInPlace();
  }
  return design;
}

ForceFeedback design_gains(const DesignModel& model, const std::vector<ModeTarget>& targets,
                           GainOrder order) {
  const GainDesign design = extended_gains(model.legs, targets, order);
  const ExtendedMatrix Q = extended(model.Q);
  return {.K_P = rounded(Q * without_one(design.X) * Q.transpose()),
          .K_I = rounded(Q * design.K_I * Q.transpose())};
}

ForceFeedback design_gains(const LegMatrices& legs, double omega_d, double zeta, GainOrder order,
                           double leak) {
  ForceFeedback gains = extended_gains(legs, {{omega_d, zeta}}, order).gains();
  gains.leak = leak;
  return gains;
}

VectorXd virtual_frequencies(const LegMatrices& legs) {
  // Any target: the frequencies are those of the legs.
  return virtual_modes(legs, {{1, 1}}).squares.cast<double>().cwiseSqrt();
}

}  // namespace stillframe

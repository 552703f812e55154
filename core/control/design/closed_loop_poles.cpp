#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/positive_definite.hpp"

namespace stillframe {

using Eigen::Index;

namespace {

/// Leak, high-pass and roll-off, rad/s, and the lead, s.
struct Corners {
  double leak = 0, high_pass = 0, roll_off = 0, lead = 0;
};

Corners corners_of(const ForceFeedback& gains) {
  // A high-pass alone is a leak.
  if (gains.leak == 0) {
    return {.leak = gains.high_pass, .roll_off = gains.roll_off, .lead = gains.lead};
  }
  return {gains.leak, gains.high_pass, gains.roll_off, gains.lead};
}

/// The law and the legs in the coordinates L^T q and L^-1 sigma, all r x r.
struct Scaled {
  ExtendedMatrix K;        ///< L^-1 K L^-T
  ExtendedMatrix X_K;      ///< L^-1 X^-1 K L^-T
  ExtendedMatrix X, X_KI;  ///< L^-1 X^-1 L, L^-1 X^-1 K_I L
};

Scaled scaled(const LegMatrices& legs, const GainDesign& design) {
  const ExtendedMatrix L = mass_factor(legs.M), K = extended(legs.K);
  const auto on_the_right = [&](const ExtendedMatrix& A) -> ExtendedMatrix {
    return forward_solve(L, A.transpose()).transpose();
  };
  const auto transformed = [&](const ExtendedMatrix& A) -> ExtendedMatrix {
    return forward_solve(L, solve(design.X, A));
  };
  const Scaled loop{.K = on_the_right(forward_solve(L, K)),
                    .X_K = on_the_right(transformed(K)),
                    .X = transformed(L),
                    .X_KI = transformed(design.K_I * L)};
  if (!rounded(loop.X).allFinite() || !rounded(loop.X_KI).allFinite()) {
    throw Refusal("K_P: I + K_P is singular, so that the loop has no poles to speak of");
  }
  return loop;
}

/// The state matrix in the blocks q', sigma_0, d, g, q, of which those are left out that nothing
/// needs: d without a roll-off, g without a high-pass, q without a leak.
ExtendedMatrix state_matrix(const Scaled& loop, const Corners& corners, double omega_scale) {
  const Index r = loop.K.rows();
  const ExtendedMatrix I = ExtendedMatrix::Identity(r, r);
  const DoubleDouble omega_l = corners.leak, omega_h = corners.high_pass, scale = omega_scale;
  const bool has_d = corners.roll_off > 0, has_g = corners.high_pass > 0, has_q = corners.leak > 0;
  const Index d = 2, g = d + (has_d ? 1 : 0), q = g + (has_g ? 1 : 0), n = q + (has_q ? 1 : 0);
  ExtendedMatrix A = ExtendedMatrix::Zero(n * r, n * r);
  const auto block = [&](Index i, Index j) { return A.block(i * r, j * r, r, r); };
  // Forces are divided, and displacements multiplied, by omega_scale: all in one unit.
  block(0, 1) = -scale * I;
  block(1, 0) = loop.X_K / scale;
  block(1, 1) = -omega_l * loop.X - loop.X_KI;
  if (has_g) {
    const ExtendedMatrix of_g = omega_h * (I - loop.X);  // X^-1 K_P g' = of_g (sigma_0 - g)
    block(1, 1) += of_g;
    block(1, g) = loop.X_KI - of_g;
    block(g, 1) = omega_h * I;
    block(g, g) = -omega_h * I;
  }
  if (has_q) {
    block(1, q) = (omega_l / (scale * scale)) * loop.X_K;
    block(q, 0) = scale * I;
  }
  if (has_d) {
    block(0, d) = -scale * I;
    A.middleRows(d * r, r) = -A.middleRows(r, r);
    block(d, 0) += loop.K / scale;
    A.middleRows(d * r, r) *= 1 - DoubleDouble(corners.lead) * DoubleDouble(corners.roll_off);
    block(d, d) -= DoubleDouble(corners.roll_off) * I;
  }
  return A;
}

Eigen::VectorXcd poles(const LegMatrices& legs, const GainDesign& design, const Corners& corners,
                       double omega_scale) {
  const Eigen::VectorXcd moving =
      eigenvalues(state_matrix(scaled(legs, design), corners, omega_scale));
  if (corners.leak > 0) return moving;
  Eigen::VectorXcd all = Eigen::VectorXcd::Zero(moving.size() + legs.M.rows());
  all.tail(moving.size()) = moving;
  return all;
}

}  // namespace

Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const ForceFeedback& gains,
                                   double omega_scale) {
  const Index r = legs.M.rows();
  const GainDesign design{.X = extended(gains.K_P) + ExtendedMatrix::Identity(r, r),
                          .K_I = extended(gains.K_I)};
  return poles(legs, design, corners_of(gains), omega_scale);
}

Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const GainDesign& design,
                                   double omega_scale) {
  return poles(legs, design, {}, omega_scale);
}

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// Mass and stiffness as the legs feel them, m x m: M in kg, K in N/m.
struct LegMatrices {
  Eigen::MatrixXd M, K;
};

/// Turns M_dd and K_dd into leg coordinates, so that the gains do not depend on the choice of q^d:
///   M = E^-T M_dd E^-1, K = E^-T K_dd E^-1, E = D_dF^(e) of the legs (m x n_d),
/// computed in twice the working precision and rounded once. Errors: Refusal if the legs are not as
/// many as the dofs or do not determine them.
LegMatrices leg_matrices(const Eigen::MatrixXd& M_dd, const Eigen::MatrixXd& K_dd,
                         const Eigen::MatrixXd& E);

/// Natural frequencies closer than this part of themselves count as one, whose shapes are not
/// determined.
inline constexpr double same_frequency = 1e-6;

/// Names for the messages of design_model; numbers stand in for names that are not given.
struct DesignNames {
  std::vector<std::string> dofs, legs;  ///< n_d, m
};

/// The model that the gains are designed for, of r = min(m, n_d) virtual legs: stress s = Q^T sigma
/// (r, N) and elongation Q^T e (r, m), with the forces u = Q v (m, N) of commands v (r, N).
///   m = n_d: the legs themselves, Q = I;
///   m > n_d: Q is an orthonormal basis of the elongations that the dofs can have, so that the
///     leg forces Q v are those of least sum of squares for their effect E^T u on the dofs, and the
///     m - n_d states of self-stress, Q^T u = 0, are left alone;
///   m < n_d: the legs themselves, Q = I, on a motion that stands for their elongations:
///     modes: the m slowest modes, q = Phi_m eta, exact for these and silent about the others;
///     static_shapes: the motion of least strain energy, q = K^-1 E^T (E K^-1 E^T)^-1 e, with which
///       the compliance of the legs E (s^2 M + K)^-1 E^T is right up to the order s^2 at s = 0.
/// No choice depends on that of q^d.
struct DesignModel {
  LegMatrices legs;   ///< r x r, symmetric: kg, N/m
  Eigen::MatrixXd Q;  ///< m x r, Q^T Q = I
};

/// The design model of m legs on n_d dofs, from M_dd, K_dd (n_d x n_d, symmetric, var) and
/// E = D_dF^(e) of the legs (m x n_d), computed in twice the working precision and rounded once.
/// Errors: Refusal if a motion strains none of the legs or an elongation of the legs belongs to no
/// motion, if M_dd is singular, if modes m and m + 1 are of one frequency (`modes`), or if K_dd is
/// singular (`static_shapes`); std::invalid_argument on shapes.
DesignModel design_model(const Eigen::MatrixXd& M_dd, const Eigen::MatrixXd& K_dd,
                         const Eigen::MatrixXd& E, Reduction reduction = Reduction::static_shapes,
                         const DesignNames& names = {});

}  // namespace stillframe

#include "core/control/h2_law.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/numerics/riccati.hpp"

namespace stillframe {

using Eigen::MatrixXd;

H2Law h2_law(const H2Problem& p) {
  const RiccatiSolution control = solve_riccati({.A = p.A,
                                                 .B = p.B_u,
                                                 .Q = p.C_z.transpose() * p.C_z,
                                                 .R = p.D_zu.transpose() * p.D_zu,
                                                 .S = p.C_z.transpose() * p.D_zu});
  const RiccatiSolution filter = solve_riccati({.A = p.A.transpose(),
                                                .B = p.C_e.transpose(),
                                                .Q = p.B_w * p.B_w.transpose(),
                                                .R = p.D_ew * p.D_ew.transpose(),
                                                .S = p.B_w * p.D_ew.transpose()});
  const MatrixXd &X = control.X, &K = control.K, &Y = filter.X;
  const MatrixXd L = filter.K.transpose();
  const MatrixXd V = p.C_e * Y * p.C_e.transpose() + p.D_ew * p.D_ew.transpose();
  const MatrixXd R_x = p.D_zu.transpose() * p.D_zu + p.B_u.transpose() * X * p.B_u;
  const MatrixXd K_w =
      R_x.ldlt().solve(p.B_u.transpose() * X * p.B_w + p.D_zu.transpose() * p.D_zw);
  const MatrixXd to_V = K * Y * p.C_e.transpose() + K_w * p.D_ew.transpose();
  const MatrixXd N = V.ldlt().solve(to_V.transpose()).transpose();

  H2Law out;
  out.radius = std::max(control.radius, filter.radius);
  out.law.C = -K + N * p.C_e;
  out.law.D = -N;
  out.law.A = p.A - L * p.C_e + p.B_u * out.law.C;
  out.law.B = L + p.B_u * out.law.D;
  // Of a law that knows x and w, and of what is not known of its command.
  const MatrixXd unknown = K * Y * K.transpose() + K_w * K_w.transpose() - N * V * N.transpose();
  out.cost = (p.B_w.transpose() * X * p.B_w).trace() + p.D_zw.squaredNorm() -
             (K_w.transpose() * R_x * K_w).trace() + (R_x * unknown).trace();
  return out;
}

}  // namespace stillframe

#include "core/mechanics/frequency_response.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/mechanics/state_space.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

Complex position_of(Quantity quantity, Complex s) {
  switch (traits_of(quantity).derivative) {
    case 1:
      return 1.0 / s;
    case 2:
      return 1.0 / (s * s);
    default:
      return 1.0;
  }
}

MatrixXcd transfer_function(const LinearModel& model, Complex s) {
  const Index n_u = model.B.cols();
  // Of forces nothing is multiplied by it: their columns of M_r to R_a are zero.
  Eigen::VectorXcd position(n_u);
  for (Index j = 0; j < n_u; ++j) {
    position(j) = position_of(model.inputs[static_cast<size_t>(j)].quantity, s);
  }
  const auto w = position.asDiagonal();
  const MatrixXcd H = s * s * model.M.cast<Complex>() + s * model.damping().cast<Complex>() +
                      model.stiffness().cast<Complex>();
  const MatrixXcd drive = model.B.cast<Complex>() - (s * s * model.M_r.cast<Complex>() +
                                                     s * model.damping_r().cast<Complex>() +
                                                     model.stiffness_r().cast<Complex>()) *
                                                        w;
  const MatrixXcd Y =
      model.Y_p.cast<Complex>() + s * model.Y_v.cast<Complex>() + s * s * model.Y_a.cast<Complex>();
  const MatrixXcd R =
      model.R_p.cast<Complex>() + s * model.R_v.cast<Complex>() + s * s * model.R_a.cast<Complex>();
  return Y * H.partialPivLu().solve(drive) + R * w + model.D_u.cast<Complex>();
}

MatrixXcd closed_loop(const MatrixXcd& G, Index n_w, Index n_y, const MatrixXcd& C) {
  const Index m_u = G.cols() - n_w, m_y = G.rows() - n_y;
  const MatrixXcd G_12 = G.topRightCorner(n_y, m_u), G_22 = G.bottomRightCorner(m_y, m_u);
  const MatrixXcd loop = MatrixXcd::Identity(m_y, m_y) - G_22 * C;
  return G.topLeftCorner(n_y, n_w) +
         G_12 * C * loop.partialPivLu().solve(G.bottomLeftCorner(m_y, n_w));
}

Eigen::VectorXd logarithmic_frequencies(double from_hz, double to_hz, Index n) {
  return Eigen::VectorXd::LinSpaced(n, std::log(from_hz), std::log(to_hz)).array().exp();
}

}  // namespace stillframe

#include "core/mechanics/sparse/sparse_response.hpp"

#include <limits>
#include <utility>

#include "core/mechanics/frequency_response.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

namespace {

double as(double, Complex value) { return value.real(); }
Complex as(Complex, Complex value) { return value; }

}  // namespace

SparseResponse::SparseResponse(const MixedModel& mixed, const MixedState& state,
                               MixedSignals signals)
    : signals_(std::move(signals)),
      E_(mixed.strain_rows(state.x)),
      M_(mixed.mass(state.x)),
      D_(mixed.damping(state.x)),
      G_(mixed.geometric_stiffness(state)),
      compliance_(mixed.compliance()),
      damping_time_(mixed.damping_time()),
      damped_(mixed.damped() || !signals_.D_w.isZero(0)) {}

template <class Scalar>
MatrixXcd SparseResponse::at(Complex s, MixedFactors<Scalar>& factors) const {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const Scalar p = as(Scalar(), s), square = as(Scalar(), s * s);
  Eigen::SparseMatrix<Scalar> A = square * M_.cast<Scalar>() + G_.cast<Scalar>();
  Vector compliance = compliance_.template cast<Scalar>();
  if (damped_) {
    A += p * D_.cast<Scalar>();
    compliance.array() /= Scalar(1) + p * damping_time_.cast<Scalar>().array();
  }
  const Index n_u = signals_.n_inputs(), n_y = signals_.n_outputs();
  MatrixXcd G = MatrixXcd::Constant(n_y, n_u, std::numeric_limits<double>::quiet_NaN());
  if (!factors.compute(E_, compliance, A)) return G;
  const auto of = [s](const Eigen::MatrixXd& p_, const Eigen::MatrixXd& v, const Eigen::MatrixXd& a,
                      Index j) -> Eigen::VectorXcd {
    return p_.col(j) + s * v.col(j) + s * s * a.col(j);
  };
  const MatrixXcd Y = signals_.Y_p + s * signals_.Y_v + s * s * signals_.Y_a;
  Vector stress, x;
  for (Index j = 0; j < n_u; ++j) {
    // By a position of one, or a force of one: real where the matrix is.
    const bool motion = is_motion(signals_.inputs[static_cast<size_t>(j)].quantity);
    const Eigen::VectorXcd force = -of(signals_.K_w, signals_.D_w, signals_.M_w, j);
    Vector f = signals_.F.col(j).template cast<Scalar>();
    if (motion) f = force.unaryExpr([](Complex value) { return as(Scalar(), value); });
    factors.solve(signals_.e.col(j).template cast<Scalar>(), f, stress, x);
    G.col(j) = signals_.S * stress + Y * x + signals_.D_u.col(j);
    if (motion) G.col(j) += of(signals_.R_p, signals_.R_v, signals_.R_a, j);
    G.col(j) *= position_of(signals_.inputs[static_cast<size_t>(j)].quantity, s);
  }
  return G;
}

MatrixXcd SparseResponse::operator()(Complex s) {
  const bool real = !damped_ && (s.real() == 0 || s.imag() == 0);
  return real ? at(s, real_) : at(s, complex_);
}

}  // namespace stillframe

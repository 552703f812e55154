#include "core/mechanics/inertia/superelement_mass.hpp"

#include "core/mechanics/inertia/body.hpp"

namespace stillframe {

namespace {

using Index = Eigen::Index;
using Block = Eigen::Matrix<double, 6, 7>;

constexpr Index position(Index k) { return 7 * k; }
constexpr Index rotation(Index k) { return 7 * k + 3; }

/// Rows are n_i^T d(R(lambda) n_i)/d lambda: the derivative of R^T h for a constant h.
Eigen::Matrix<double, 3, 4> d_turned_back(const Vector4& lambda, const Vector3& h) {
  Eigen::Matrix<double, 3, 4> rows;
  for (int i = 0; i < 3; ++i) {
    rows.row(i) = h.transpose() * d_rotated_d_lambda(lambda, Vector3::Unit(i));
  }
  return rows;
}

/// One interface node as it moves.
struct Node {
  Vector4 lambda, turning, turning_faster;
  Vector3 velocity, acceleration;
  Eigen::Matrix3d R, R_1;  ///< R and its time derivative

  Node(const LocalVector& u, const LocalVector& v, const LocalVector& a, Index k)
      : lambda(euler_parameters(u.segment<4>(rotation(k)))),
        turning(v.segment<4>(rotation(k))),
        turning_faster(a.segment<4>(rotation(k))),
        velocity(v.segment<3>(position(k))),
        acceleration(a.segment<3>(position(k))) {
    for (int i = 0; i < 3; ++i) {
      const Vector3 n = Vector3::Unit(i);
      R.col(i) = n + rotation_form(lambda, lambda, n);
      R_1.col(i) = 2.0 * rotation_form(lambda, turning, n);
    }
  }

  /// w and w'.
  Eigen::Matrix<double, 6, 1> rates() const {
    Eigen::Matrix<double, 6, 1> w;
    w << R.transpose() * velocity, 2.0 * body_rate_matrix(lambda) * turning;
    return w;
  }
  Eigen::Matrix<double, 6, 1> rates_of_rates() const {
    Eigen::Matrix<double, 6, 1> w;
    w << R.transpose() * acceleration + R_1.transpose() * velocity,
        2.0 * body_rate_matrix(lambda) * turning_faster;
    return w;
  }
  /// T with w = T u'.
  Block T() const { return block(R.transpose(), 2.0 * body_rate_matrix(lambda)); }
  /// Time derivative of T less dw/du: what p does to F besides T^T p'.
  Block Q() const {
    Block q = block(R_1.transpose(), 4.0 * body_rate_matrix(turning));
    q.block<3, 4>(0, 3) = -d_turned_back(lambda, velocity);
    return q;
  }
  Block w_by_u() const {
    Block W = Block::Zero();
    W.block<3, 4>(0, 3) = d_turned_back(lambda, velocity);
    W.block<3, 4>(3, 3) = -2.0 * body_rate_matrix(turning);
    return W;
  }
  Block w_rate_by_v() const {
    Block Y = Block::Zero();
    Y.topLeftCorner<3, 3>() = R_1.transpose();
    Y.block<3, 4>(0, 3) = d_turned_back(lambda, velocity);
    return Y;
  }
  Block w_rate_by_u() const {
    Block Z = Block::Zero();
    Z.block<3, 4>(0, 3) = d_turned_back(lambda, acceleration) + d_turned_back(turning, velocity);
    Z.block<3, 4>(3, 3) = -2.0 * body_rate_matrix(turning_faster);
    return Z;
  }

 private:
  static Block block(const Eigen::Matrix3d& a, const Eigen::Matrix<double, 3, 4>& b) {
    Block whole = Block::Zero();
    whole.topLeftCorner<3, 3>() = a;
    whole.bottomRightCorner<3, 4>() = b;
    return whole;
  }
};

}  // namespace

Eigen::MatrixXd rigid_motions(const Eigen::Matrix3Xd& s, Index n_modes) {
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(6 * s.cols() + n_modes, 6);
  for (Index k = 0; k < s.cols(); ++k) {
    E.block<6, 6>(6 * k, 0).setIdentity();
    E.block<3, 3>(6 * k, 3) = -cross_matrix(s.col(k));
  }
  return E;
}

Eigen::Matrix<double, 6, 6> rigid_mass(const Eigen::Matrix3Xd& s, const Eigen::MatrixXd& M) {
  const Eigen::MatrixXd E = rigid_motions(s, M.rows() - 6 * s.cols());
  return E.transpose() * M * E;
}

SuperelementMass::SuperelementMass(Superelement element, const Eigen::Matrix3Xd& s,
                                   const Eigen::MatrixXd& M)
    : Inertia(element.parts()), element_(std::move(element)), M_(M) {
  const Eigen::MatrixXd E = rigid_motions(s, element_.n_modes());
  const Eigen::Matrix3Xd momentum = E.leftCols<3>().transpose() * M_;
  const Eigen::Matrix<double, 3, 6> rigid = momentum * E;
  m_ = rigid.leftCols<3>().trace() / 3;
  // Of a turn omega: omega x m c = -[m c]x omega.
  m_c_ << rigid(1, 5) - rigid(2, 4), rigid(2, 3) - rigid(0, 5), rigid(0, 4) - rigid(1, 3);
  m_c_ *= 0.5;
  P_ = momentum.rightCols(momentum.cols() - 6);
}

/// M times block-diagonal columns: (6 n + n_modes) x n_local.
template <class OfNode>
LocalHessian SuperelementMass::times(const OfNode& block, bool modes) const noexcept {
  const Index n = element_.n_nodes(), n_modes = element_.n_modes();
  LocalHessian product = LocalHessian::Zero(M_.rows(), n_local());
  for (Index k = 0; k < n; ++k) {
    product.middleCols<7>(position(k)).noalias() = M_.middleCols<6>(6 * k) * block(k);
  }
  if (modes) product.middleCols(position(n), n_modes) = M_.rightCols(n_modes);
  return product;
}

template <class OfNode>
void SuperelementMass::add_transposed(const OfNode& block, bool modes, const LocalHessian& right,
                                      LocalHessian& sum) const noexcept {
  const Index n = element_.n_nodes(), n_modes = element_.n_modes();
  for (Index k = 0; k < n; ++k) {
    sum.middleRows<7>(position(k)).noalias() += block(k).transpose() * right.middleRows<6>(6 * k);
  }
  if (modes) sum.middleRows(position(n), n_modes) += right.bottomRows(n_modes);
}

LocalDeformation SuperelementMass::deformations(const LocalVector& u) const noexcept {
  LocalDeformation e(element_.n_deformations());
  element_.deformations(u, e);
  return e;
}

void SuperelementMass::mass(const LocalVector& u, LocalHessian& M) const noexcept {
  const LocalVector none = LocalVector::Zero(n_local());
  const auto T = [&](Index k) { return Node(u, none, none, k).T(); };
  M.setZero();
  add_transposed(T, true, times(T, true), M);
}

void SuperelementMass::force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                             const Eigen::Vector3d& g, LocalVector& F) const noexcept {
  const Index n = element_.n_nodes(), n_modes = element_.n_modes();
  LocalVector w(M_.rows()), w_rate(M_.rows());
  for (Index k = 0; k < n; ++k) {
    const Node node(u, v, a, k);
    w.segment<6>(6 * k) = node.rates();
    w_rate.segment<6>(6 * k) = node.rates_of_rates();
  }
  w.tail(n_modes) = v.segment(position(n), n_modes);
  w_rate.tail(n_modes) = a.segment(position(n), n_modes);
  LocalVector p(M_.rows()), p_rate(M_.rows());
  p.noalias() = M_ * w;
  p_rate.noalias() = M_ * w_rate;
  F.setZero();
  for (Index k = 0; k < n; ++k) {
    const Node node(u, v, a, k);
    F.segment<7>(position(k)) = node.T().transpose() * p_rate.segment<6>(6 * k) +
                                node.Q().transpose() * p.segment<6>(6 * k);
  }
  F.segment(position(n), n_modes) = p_rate.tail(n_modes);
  if (g.isZero(0)) return;
  const Node first(u, v, a, 0);
  LocalJacobian D(element_.n_deformations(), n_local());
  element_.jacobian(u, D);
  const Vector3 moved = m_c_ + P_ * deformations(u);
  const LocalDeformation weight = P_.transpose() * (first.R.transpose() * g);
  F.segment<3>(position(0)) -= m_ * g;
  F.segment<4>(rotation(0)) -= d_rotated_d_lambda(first.lambda, moved).transpose() * g;
  F.noalias() -= D.transpose() * weight;
}

void SuperelementMass::tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                                const Eigen::Vector3d& g, LocalHessian& d_F_d_v,
                                LocalHessian& d_F_d_u) const noexcept {
  const Index n = element_.n_nodes(), n_modes = element_.n_modes();
  const auto node = [&](Index k) { return Node(u, v, a, k); };
  const auto T = [&](Index k) { return node(k).T(); };
  const auto Q = [&](Index k) { return node(k).Q(); };
  d_F_d_v.setZero();
  d_F_d_u.setZero();
  // F = T^T M w' + Q^T M w; the modes' own rows have T = 1 and the rest 0.
  add_transposed(T, true, times([&](Index k) { return node(k).w_rate_by_v(); }, false), d_F_d_v);
  add_transposed(T, true, times([&](Index k) { return node(k).w_rate_by_u(); }, false), d_F_d_u);
  add_transposed(Q, false, times(T, true), d_F_d_v);
  add_transposed(Q, false, times([&](Index k) { return node(k).w_by_u(); }, false), d_F_d_u);

  // T and Q themselves change, of each node by its own motion.
  LocalVector w(M_.rows()), w_rate(M_.rows());
  for (Index k = 0; k < n; ++k) {
    w.segment<6>(6 * k) = node(k).rates();
    w_rate.segment<6>(6 * k) = node(k).rates_of_rates();
  }
  w.tail(n_modes) = v.segment(position(n), n_modes);
  w_rate.tail(n_modes) = a.segment(position(n), n_modes);
  for (Index k = 0; k < n; ++k) {
    const Node own = node(k);
    const Index r = position(k), l = rotation(k);
    const Eigen::Matrix<double, 6, 1> p = M_.middleRows<6>(6 * k) * w,
                                      p_rate = M_.middleRows<6>(6 * k) * w_rate;
    const Vector3 force = p_rate.head<3>(), momentum = p.head<3>();
    const auto by_lambda = d_rotated_d_lambda(own.lambda, momentum);
    d_F_d_u.block<3, 4>(r, l) +=
        d_rotated_d_lambda(own.lambda, force) + d_rotated_d_lambda(own.turning, momentum);
    d_F_d_u.block<4, 4>(l, l) +=
        2.0 * d_body_rate_dual(p_rate.tail<3>()) - rotated_hessian(own.velocity, momentum);
    d_F_d_v.block<3, 4>(r, l) += by_lambda;
    d_F_d_v.block<4, 3>(l, r) -= by_lambda.transpose();
    d_F_d_v.block<4, 4>(l, l) += 4.0 * d_body_rate_dual(p.tail<3>());
  }
  if (g.isZero(0)) return;

  const Node first = node(0);
  LocalJacobian D(element_.n_deformations(), n_local());
  element_.jacobian(u, D);
  const Vector3 moved = m_c_ + P_ * deformations(u);
  const LocalDeformation weight = P_.transpose() * (first.R.transpose() * g);
  LocalHessian H(n_local(), n_local());
  element_.hessian(u, weight, H);
  d_F_d_u -= H;
  d_F_d_u.block<4, 4>(rotation(0), rotation(0)) -= rotated_hessian(g, moved);
  // d/du of R_1 P e: its rows through lambda_1, those through e are symmetric to them.
  Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, max_local> turned(4, n_local());
  Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, max_deformations> by_e(4, P_.cols());
  by_e.noalias() = d_turned_back(first.lambda, g).transpose() * P_;
  turned.noalias() = by_e * D;
  d_F_d_u.middleRows<4>(rotation(0)) -= turned;
  d_F_d_u.middleCols<4>(rotation(0)) -= turned.transpose();
}

double SuperelementMass::gravity_energy(const LocalVector& u,
                                        const Eigen::Vector3d& g) const noexcept {
  const Vector4 lambda = euler_parameters(u.segment<4>(rotation(0)));
  const Vector3 in_frame = P_ * deformations(u);
  return -g.dot(m_ * u.segment<3>(position(0)) + rotation_form(lambda, lambda, m_c_) + in_frame +
                rotation_form(lambda, lambda, in_frame));
}

}  // namespace stillframe

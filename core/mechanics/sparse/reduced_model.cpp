#include "core/mechanics/sparse/reduced_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/errors/input_error.hpp"
#include "core/mechanics/sparse/lowest_modes.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/sparse/mixed_signals.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/lanczos.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A correction that would swing faster than so many times what was left out has no mass to swing.
constexpr double fastest = 1000;
/// So little of what a correction does at the top of the band may be lost; the bound counts it.
constexpr double little = 1e-6;

/// The equations and signals in x alone, beside the motion psi w that prescribed motions lead to at
/// rest: M x'' + D x' + K x = F u - M_w w'' - D_w w' - K_w w.
struct Forms {
  MatrixXd F, M_w, D_w, K_w;    ///< n_c x n_u
  MatrixXd Y_p, Y_v, Y_a;       ///< n_c x n_y, transposed
  MatrixXd R_p, R_v, R_a, D_u;  ///< n_y x n_u
};

class Reducer {
 public:
  Reducer(const MixedModel& mixed, const MixedState& state, MixedSignals signals)
      : mixed_(mixed),
        state_(state),
        signals_(std::move(signals)),
        E_(mixed.strain_rows(state.x)),
        M_(mixed.mass(state.x)),
        D_(mixed.damping(state.x)),
        G_(mixed.geometric_stiffness(state)),
        viscosity_(mixed.stiffness().cwiseProduct(mixed.damping_time())) {}

  ReducedModel reduce(const SceneReduction& asked) {
    find_modes(asked);
    factorise();
    polish_modes();
    in_position_alone();
    find_corrections();
    V_.resize(M_.rows(), n_m_ + Z_.cols());
    V_ << V_m_, Z_;
    K_V_.resize(M_.rows(), V_.cols());
    K_V_ << K_V_m_, K_Z_;
    ReducedModel model;
    model.n_modes = n_m_;
    model.n_corrections = Z_.cols();
    model.to_hz = to_hz_;
    model.first_left_out_hz = first_left_out_ / two_pi;
    const LinearModel V = projected();
    model.linear = with_unit_masses(V);
    model.left_out = bound(V);
    model.n_in = model.linear.B.cols();
    model.n_out = model.linear.Y_p.rows();
    return model;
  }

 private:
  void find_modes(const SceneReduction& asked);
  void factorise();
  void polish_modes();
  double largest_damping() const;
  void in_position_alone();
  void add_motions();
  void add_stresses();
  void find_corrections();
  LinearModel projected() const;
  LinearModel with_unit_masses(const LinearModel& V) const;
  ReductionBound bound(LinearModel V) const;

  /// D x of all dampers, those of a damping_time too.
  MatrixXd damped(const MatrixXd& x) const {
    return D_ * x + E_.transpose() * (viscosity_.asDiagonal() * (E_ * x));
  }
  /// f without its part on the kept modes, which would drown what is left of it in rounding.
  MatrixXd without_modes(const MatrixXd& f) const {
    MatrixXd left = f;
    for (int i = 0; i < 2; ++i) left -= M_V_m_ * (V_m_.transpose() * left).eval();
    return left;
  }
  /// K_s^-1 f of every column.
  MatrixXd solved(const MatrixXd& f) const {
    MatrixXd x(f.rows(), f.cols());
    VectorXd s, one;
    for (Index j = 0; j < f.cols(); ++j) {
      factors_.solve({}, f.col(j), s, one);
      x.col(j) = one;
    }
    return x;
  }
  /// The same where the kept modes have no part.
  MatrixXd solved_beside(const MatrixXd& f) const {
    MatrixXd x = solved(f);
    for (int i = 0; i < 2; ++i) x -= V_m_ * (M_V_m_.transpose() * x).eval();
    return x;
  }

  const MixedModel& mixed_;
  const MixedState& state_;
  MixedSignals signals_;
  SparseMatrix E_, M_, D_, G_;
  VectorXd viscosity_;

  Index n_m_ = 0;
  double shift_ = 0, first_left_out_ = 0, to_hz_ = 0;
  VectorXd squares_, known_to_;
  MatrixXd V_m_, M_V_m_, K_V_m_, Z_, K_Z_, V_, K_V_;  ///< K: times K_s
  VectorXd Z_masses_;  ///< of corrections with z^T K_s z = 1, the heaviest first
  MixedFactors<double> factors_;
  Forms forms_;
};

/// As many modes as are asked for, but all free motions, and the next one, which says what is left
/// out.
void Reducer::find_modes(const SceneReduction& asked) {
  const bool counted = asked.n_modes > 0;
  const double top = two_pi * (asked.modes_to_hz > 0 ? asked.modes_to_hz : 2 * asked.to_hz);
  Index n = std::min<Index>(counted ? asked.n_modes + 1 : 20, M_.rows());
  LowestModes found;
  const auto enough = [&](Index n_found) {
    const double last = found.squares(n_found - 1);
    return last > 0 && (counted || last > top * top);
  };
  while (true) {
    found = lowest_modes(mixed_, state_, n);
    const Index n_found = found.squares.size();
    if (n_found < n || n == M_.rows() || enough(n_found)) break;
    n = std::min(2 * n, M_.rows());
  }
  const Index n_found = found.squares.size();
  while (n_m_ < n_found && (found.squares(n_m_) == 0 ||
                            (counted ? n_m_ < asked.n_modes : found.squares(n_m_) <= top * top))) {
    ++n_m_;
  }
  squares_ = found.squares.head(n_m_);
  known_to_ = found.known_to.head(n_m_);
  V_m_ = found.shapes.leftCols(n_m_);
  const bool all = n_m_ == n_found;
  first_left_out_ = all ? infinity : std::sqrt(found.squares(n_m_));
  const double highest = n_m_ > 0 ? found.natural_frequencies_hz(n_m_ - 1) : 0;
  to_hz_ = asked.to_hz > 0 ? asked.to_hz : all ? highest : first_left_out_ / (4 * std::numbers::pi);
  // What moves freely makes the stiffness singular: seen from a tenth below what does not.
  if (n_found == 0 || found.squares(0) > 0) return;
  const auto elastic = std::find_if(found.squares.begin(), found.squares.end(),
                                    [](double square) { return square > 0; });
  shift_ = elastic == found.squares.end() ? 1 : 0.1 * *elastic;
}

void Reducer::factorise() {
  if (!factors_.compute(E_, mixed_.compliance(), SparseMatrix(shift_ * M_ + G_))) {
    throw Refusal("the stiffness matrix is singular: something without mass can move freely");
  }
}

/// By one inverse iteration, so that what K_s does to the modes is known as forces.
void Reducer::polish_modes() {
  K_V_m_ = M_ * V_m_ * (squares_.array() + shift_).matrix().asDiagonal();
  V_m_ = solved(K_V_m_);
  // Each without its part on slower ones, which the iteration brings up from rounding.
  const Eigen::LLT<MatrixXd> masses(V_m_.transpose() * (M_ * V_m_));
  masses.matrixU().solveInPlace<Eigen::OnTheRight>(V_m_);
  masses.matrixU().solveInPlace<Eigen::OnTheRight>(K_V_m_);
  M_V_m_ = M_ * V_m_;
}

/// D over K_s at most, s; infinite where that is not found.
double Reducer::largest_damping() const {
  const SparseMatrix D = D_ + SparseMatrix(E_.transpose() * (viscosity_.asDiagonal() * E_));
  if (D.nonZeros() == 0 || D.cwiseAbs().sum() == 0) return 0;
  VectorXd s;
  const LanczosPairs found = largest_pairs(
      D, 1, Largest::modulus, [&](const VectorXd& f, VectorXd& y) { factors_.solve({}, f, s, y); });
  // Converged to far more than one per cent.
  return found.converged && found.values.size() > 0 ? 1.01 * std::abs(found.values(0)) : infinity;
}

void Reducer::in_position_alone() {
  forms_ = {signals_.F,
            signals_.M_w,
            signals_.D_w - E_.transpose() * (viscosity_.asDiagonal() * signals_.e),
            MatrixXd::Zero(M_.rows(), signals_.n_inputs()),
            signals_.Y_p.transpose(),
            signals_.Y_v.transpose(),
            signals_.Y_a.transpose(),
            signals_.R_p,
            signals_.R_v,
            signals_.R_a,
            signals_.D_u};
  add_stresses();
  add_motions();
}

/// a^T s of an output, from the balance of forces: of the answer (s_T, T) to a dislocation a,
///   a^T s = T^T (E^T s) - s_T^T c s,   c s = (1 + time d/dt) (E x - e w).
void Reducer::add_stresses() {
  VectorXd s_T, T;
  for (Index i = 0; i < signals_.n_outputs(); ++i) {
    const VectorXd a = signals_.S.row(i).transpose();
    if (a.isZero(0)) continue;
    factors_.solve(a, VectorXd::Zero(M_.rows()), s_T, T);
    const VectorXd M_T = M_ * T, time_s = mixed_.damping_time().cwiseProduct(s_T);
    forms_.Y_p.col(i) += shift_ * M_T;
    forms_.Y_v.col(i) -= D_ * T + E_.transpose() * time_s;
    forms_.Y_a.col(i) -= M_T;
    forms_.D_u.row(i) += T.transpose() * signals_.F;
    forms_.R_p.row(i) += s_T.transpose() * signals_.e - T.transpose() * signals_.K_w;
    forms_.R_v.row(i) += time_s.transpose() * signals_.e - T.transpose() * signals_.D_w;
    forms_.R_a.row(i) -= T.transpose() * signals_.M_w;
  }
}

/// From the motion of everything to that beside psi w.
void Reducer::add_motions() {
  VectorXd s, psi;
  for (Index j = 0; j < signals_.n_inputs(); ++j) {
    if (!is_motion(signals_.inputs[static_cast<size_t>(j)].quantity)) continue;
    factors_.solve(signals_.e.col(j), -signals_.K_w.col(j), s, psi);
    const VectorXd M_psi = M_ * psi;
    forms_.M_w.col(j) += M_psi;
    forms_.D_w.col(j) += damped(psi);
    forms_.K_w.col(j) = -shift_ * M_psi;
    forms_.R_p.col(j) += forms_.Y_p.transpose() * psi;
    forms_.R_v.col(j) += forms_.Y_v.transpose() * psi;
    forms_.R_a.col(j) += forms_.Y_a.transpose() * psi;
  }
}

/// Z: what the forces of inputs, and those that psi w'' and psi w' call for, do at rest beside the
/// kept modes, without what is a combination of others, apart from each other in M and K.
void Reducer::find_corrections() {
  MatrixXd whole(M_.rows(), 3 * forms_.F.cols());
  whole << forms_.F, forms_.M_w, forms_.D_w;
  const MatrixXd f = without_modes(whole), x = solved_beside(f);
  const VectorXd work = solved(whole).cwiseProduct(whole).colwise().sum().transpose();
  MatrixXd gram = x.transpose() * f;
  gram = (0.5 * (gram + gram.transpose())).eval();
  // What does no more than the rounding of the whole force is none; of the others only the
  // direction counts. Seen: 1e-23 of the work of the whole, where all modes are kept.
  std::vector<Index> used;
  for (Index j = 0; j < f.cols(); ++j) {
    if (gram(j, j) > 1e-16 * work(j)) used.push_back(j);
  }
  const auto n = static_cast<Index>(used.size());
  Z_masses_ = VectorXd::Zero(0);
  Z_ = K_Z_ = MatrixXd::Zero(M_.rows(), 0);
  if (n == 0) return;
  const VectorXd lengths = gram.diagonal()(used).cwiseSqrt();
  const MatrixXd cosines =
      lengths.cwiseInverse().asDiagonal() * gram(used, used) * lengths.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> independent(cosines);
  Index n_z = 0;
  while (n_z < n && independent.eigenvalues()(n - 1 - n_z) > 1e-9) ++n_z;
  const MatrixXd combine =
      lengths.cwiseInverse().asDiagonal() * independent.eigenvectors().rightCols(n_z) *
      independent.eigenvalues().tail(n_z).cwiseSqrt().cwiseInverse().asDiagonal();
  // Differences of nearly the same answers are rounded: those to differences of the forces are not.
  K_Z_ = without_modes(f(Eigen::all, used) * combine);
  Z_ = solved(K_Z_);
  for (int i = 0; i < 2; ++i) {
    const MatrixXd part = M_V_m_.transpose() * Z_;
    Z_ -= V_m_ * part;
    K_Z_ -= K_V_m_ * part;
  }
  const Eigen::LLT<MatrixXd> lengths_left(Z_.transpose() * K_Z_);
  lengths_left.matrixU().solveInPlace<Eigen::OnTheRight>(Z_);
  lengths_left.matrixU().solveInPlace<Eigen::OnTheRight>(K_Z_);
  // z^T K_s z is 1 of each, z^T M z the eigenvalue: the heaviest first.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> apart(Z_.transpose() * (M_ * Z_));
  Z_ = (Z_ * apart.eigenvectors().rowwise().reverse()).eval();
  K_Z_ = (K_Z_ * apart.eigenvectors().rowwise().reverse()).eval();
  Z_masses_ = apart.eigenvalues().reverse().cwiseMax(0);
}

/// On all modes and corrections as they are.
LinearModel Reducer::projected() const {
  const Index n = V_.cols(), n_u = forms_.F.cols();
  LinearModel model;
  for (Index i = 0; i < n; ++i) {
    const bool mode = i < n_m_;
    model.q_names.push_back((mode ? "mode " : "correction ") +
                            std::to_string(mode ? i + 1 : i - n_m_ + 1));
    model.q_units.push_back("kg^1/2 m");
  }
  model.inputs = signals_.inputs;
  model.outputs = signals_.outputs;
  const auto symmetric = [](const MatrixXd& A) -> MatrixXd { return 0.5 * (A + A.transpose()); };
  model.M = symmetric(V_.transpose() * (M_ * V_));
  model.G = symmetric(V_.transpose() * (G_ * V_));
  model.K = symmetric(V_.transpose() * K_V_) - shift_ * model.M - model.G;
  model.D = symmetric(V_.transpose() * damped(V_));
  model.C = model.N = MatrixXd::Zero(n, n);
  model.B = V_.transpose() * forms_.F;
  model.M_r = V_.transpose() * forms_.M_w;
  model.D_r = V_.transpose() * forms_.D_w;
  model.K_r = V_.transpose() * forms_.K_w;
  model.C_r = model.N_r = model.G_r = MatrixXd::Zero(n, n_u);
  model.Y_p = forms_.Y_p.transpose() * V_;
  model.Y_v = forms_.Y_v.transpose() * V_;
  model.Y_a = forms_.Y_a.transpose() * V_;
  model.R_p = forms_.R_p;
  model.R_v = forms_.R_v;
  model.R_a = forms_.R_a;
  model.D_u = forms_.D_u;
  model.x_0 = state_.x;
  model.q_0 = model.q_dot_0 = model.q_ddot_0 = VectorXd::Zero(n);
  model.u_0 = signals_.u_0;
  model.y_0 = signals_.y_0;
  return model;
}

/// The model with unit masses. What is too light to swing follows its forces at once, or, where
/// dampers or rates and accelerations of outputs hold on to it, has more mass.
LinearModel Reducer::with_unit_masses(const LinearModel& V) const {
  const double known = std::isfinite(first_left_out_) ? first_left_out_
                       : n_m_ > 0                     ? std::sqrt(squares_(n_m_ - 1))
                                                      : 0;
  const double least = 1 / (fastest * fastest * known * known + shift_);
  if (Z_.cols() > 0 && !std::isfinite(least)) throw Refusal("nothing that resists has mass");
  const double omega = two_pi * to_hz_;
  std::vector<Index> moves, follows;
  VectorXd masses = V.M.diagonal();
  for (Index i = 0; i < masses.size(); ++i) {
    const bool light = i >= n_m_ && masses(i) < least;
    const bool held = omega * V.D(i, i) > little ||
                      omega * V.Y_v.col(i).norm() + omega * omega * V.Y_a.col(i).norm() >
                          little * V.Y_p.col(i).norm();
    if (light) masses(i) = least;
    (light && !held ? follows : moves).push_back(i);
  }
  const auto n = static_cast<Index>(moves.size());
  const VectorXd scale = masses(moves).cwiseSqrt().cwiseInverse();
  const auto scaled = [&](const MatrixXd& square) -> MatrixXd {
    return scale.asDiagonal() * square(moves, moves) * scale.asDiagonal();
  };
  const auto rows = [&](const MatrixXd& of) -> MatrixXd {
    return scale.asDiagonal() * of(moves, Eigen::all);
  };
  const auto columns = [&](const MatrixXd& of) -> MatrixXd {
    return of(Eigen::all, moves) * scale.asDiagonal();
  };
  LinearModel model = V;
  model.M = MatrixXd::Identity(n, n);
  for (MatrixXd* square : {&model.D, &model.G, &model.C, &model.N}) {
    *square = scaled(*square);
  }
  for (MatrixXd* of :
       {&model.B, &model.M_r, &model.D_r, &model.K_r, &model.C_r, &model.N_r, &model.G_r}) {
    *of = rows(*of);
  }
  for (MatrixXd* of : {&model.Y_p, &model.Y_v, &model.Y_a}) *of = columns(*of);
  const VectorXd stiffness = V.stiffness().diagonal();
  VectorXd squares = scale.cwiseAbs2().cwiseProduct(stiffness(moves));
  squares.head(n_m_) = squares_;
  model.K = MatrixXd(squares.asDiagonal()) - model.G;
  model.q_names.resize(static_cast<size_t>(n));
  model.q_units.resize(static_cast<size_t>(n));
  model.q_0 = model.q_dot_0 = model.q_ddot_0 = VectorXd::Zero(n);
  const VectorXd compliance = stiffness(follows).cwiseInverse();
  const MatrixXd Y = V.Y_p(Eigen::all, follows) * compliance.asDiagonal();
  model.D_u += Y * V.B(follows, Eigen::all);
  model.R_p -= Y * V.K_r(follows, Eigen::all);
  model.R_v -= Y * V.D_r(follows, Eigen::all);
  model.R_a -= Y * V.M_r(follows, Eigen::all);
  return model;
}

ReductionBound Reducer::bound(LinearModel V) const {
  const MatrixXd M_V = M_ * V_, D_V = damped(V_);
  MatrixXd W(M_.rows(), 4 * forms_.F.cols() + 3 * V_.cols() + 3 * forms_.Y_p.cols());
  W << forms_.F, forms_.M_w, forms_.D_w, forms_.K_w, M_V, D_V, K_V_, forms_.Y_p, forms_.Y_v,
      forms_.Y_a;
  ReductionBound bound;
  W = without_modes(W);
  bound.gram = W.transpose() * solved_beside(W);
  // As much as it is not symmetric, and what sums of so many terms have at least.
  const VectorXd shorter = bound.gram.diagonal().cwiseMax(0).cwiseSqrt().cwiseInverse();
  const MatrixXd skew =
      shorter.asDiagonal() * (bound.gram - bound.gram.transpose()) * shorter.asDiagonal();
  bound.rounding = std::numeric_limits<double>::epsilon() * static_cast<double>(W.cols());
  for (const double part : skew.reshaped()) {
    if (std::isfinite(part)) bound.rounding = std::max(bound.rounding, std::abs(part));
  }
  bound.gram = (0.5 * (bound.gram + bound.gram.transpose())).eval();
  bound.n_modes = n_m_;
  bound.damping = largest_damping();
  bound.shift = shift_;
  bound.known_to = known_to_;
  bound.first_left_out = first_left_out_;
  bound.projected = std::move(V);
  return bound;
}

}  // namespace

ReducedModel reduced_model(const MixedModel& mixed, const MixedState& state,
                           const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs, const SceneReduction& asked) {
  return Reducer(mixed, state, mixed_signals(mixed, state, inputs, outputs)).reduce(asked);
}

}  // namespace stillframe

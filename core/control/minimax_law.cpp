#include "core/control/minimax_law.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/control/mode_design.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/riccati.hpp"
#include "core/numerics/stein.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr Index n_taps = 40;
/// Of the weights over the largest: what is less decides nothing, and costs the factorisation its
/// digits.
constexpr double least_weight = 1e-12;

/// The observer and its gain: x[k+1] = A x + B u + L (e - C x), u = -K x + q.
struct Observer {
  MatrixXd A, B, C, K, L;

  Observer(const SampledMode& mode, const ModeGoal& goal)
      : A(mode.ports().A), B(mode.ports().B_u), C(mode.ports().C_e) {
    const LawPorts& ports = mode.ports();
    // Any gains do that stabilise; these keep the maps to T and S of one size over the band.
    MatrixXd C_z(2, A.cols());
    C_z << ports.C_y, std::pow(goal.omega_d / mode.omega(), 2) * C;
    MatrixXd D_zu(2, 1);
    D_zu << ports.D_yu(0, 0), 0;
    constexpr double effort = 1e-3;
    K = solve_riccati({.A = A,
                       .B = B,
                       .Q = C_z.transpose() * C_z,
                       .R = D_zu.transpose() * D_zu + MatrixXd::Constant(1, 1, effort * effort),
                       .S = C_z.transpose() * D_zu})
            .K;
    const double corner = two_pi * 2 * goal.to_hz, noise = std::pow(mode.omega() / corner, 2);
    L = solve_riccati({.A = A.transpose(),
                       .B = C.transpose(),
                       .Q = ports.B_w * ports.B_w.transpose(),
                       .R = MatrixXd::Constant(1, 1, noise * noise)})
            .K.transpose();
  }

  /// With q = Q (e - C x): the filter from e to u.
  LinearSystem law(const LinearSystem& Q) const {
    const Index n = A.rows(), r = Q.A.rows();
    LinearSystem out{MatrixXd::Zero(n + r, n + r), MatrixXd(n + r, 1), MatrixXd(1, n + r), Q.D};
    out.C << -K - Q.D * C, Q.C;
    out.B << L, Q.B;
    out.A.topLeftCorner(n, n) = A - L * C;
    out.A.bottomLeftCorner(r, n) = -Q.B * C;
    out.A.bottomRightCorner(r, r) = Q.A;
    out.A.topRows(n) += B * out.C;
    out.B.topRows(n) += B * out.D;
    return out;
  }
};

/// The terms of Q: taps, then for each corner the low-pass g = (1 - p) / (z - p) and its square.
struct Basis {
  std::vector<double> memories;

  Basis(const ModeGoal& goal, double T_s) {
    for (double corner = 0.04 * goal.omega_d; corner < 0.02 * two_pi / T_s; corner *= 4) {
      memories.push_back(std::exp(-corner * T_s));
    }
  }
  Index size() const { return n_taps + 2 * std::ssize(memories); }

  MatrixXcd at(const VectorXcd& z) const {
    MatrixXcd out(z.size(), size());
    out.col(0).setOnes();
    for (Index i = 1; i < n_taps; ++i) out.col(i) = out.col(i - 1).cwiseQuotient(z);
    Index i = n_taps;
    for (const double p : memories) {
      out.col(i) = (1 - p) / (z.array() - p);
      out.col(i + 1) = out.col(i).array().square();
      i += 2;
    }
    return out;
  }

  LinearSystem system(const VectorXd& x) const {
    const Index n = size() - 1;
    LinearSystem out{MatrixXd::Zero(n, n), MatrixXd::Zero(n, 1), x.tail(n).transpose(),
                     MatrixXd::Constant(1, 1, x(0))};
    out.B(0) = 1;
    for (Index i = 1; i + 1 < n_taps; ++i) out.A(i, i - 1) = 1;
    Index i = n_taps - 1;
    for (const double p : memories) {
      out.A(i, i) = out.A(i + 1, i + 1) = p;
      out.A(i + 1, i) = 1 - p;
      out.B(i) = 1 - p;
      i += 2;
    }
    return out;
  }
};

/// r = r_0 + M x, and the x of least max |r_i|, step by step.
class Lawson {
 public:
  Lawson(const MatrixXcd& M, const VectorXcd& r_0) : r_0_(r_0) {
    const Index N = M.rows();
    MatrixXd rows(2 * N, M.cols());
    rows << M.real(), M.imag();
    const Eigen::HouseholderQR<MatrixXd> qr(rows);
    Q_ = qr.householderQ() * MatrixXd::Identity(2 * N, M.cols());
    R_ = qr.matrixQR().topRows(M.cols()).triangularView<Eigen::Upper>();
  }

  /// Until the least maximum is known to be at most one or more than `excluded`, or so many steps
  /// are over.
  void run(int most, double excluded) {
    const Index N = r_0_.size();
    VectorXd weights = VectorXd::Ones(N);
    VectorXd wanted(2 * N);
    wanted << -r_0_.real(), -r_0_.imag();
    for (int i = 0; i < most && upper > 1 && lower <= excluded; ++i) {
      weights = (weights / weights.maxCoeff()).cwiseMax(least_weight);
      weights /= weights.sum();
      const VectorXd both = weights.replicate(2, 1);
      const MatrixXd WQ = both.asDiagonal() * Q_;
      const VectorXd y = (Q_.transpose() * WQ).ldlt().solve(WQ.transpose() * wanted);
      const VectorXd left = Q_ * y - wanted;
      const VectorXd error = (left.head(N).array().square() + left.tail(N).array().square()).sqrt();
      lower = std::max(lower, std::sqrt(weights.dot(error.cwiseAbs2())));
      if (error.maxCoeff() < upper) {
        upper = error.maxCoeff();
        y_ = y;
      }
      weights = weights.cwiseProduct(error);
    }
  }

  VectorXd x() const { return R_.triangularView<Eigen::Upper>().solve(y_); }

  double lower = 0, upper = infinity;

 private:
  VectorXcd r_0_;
  MatrixXd Q_, R_;
  VectorXd y_;
};

/// A factor F with F F^T = P of a matrix that is positive semidefinite but for rounding.
MatrixXd factor(const MatrixXd& P) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> values((P + P.transpose()) / 2);
  return values.eigenvectors() * values.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// Balanced truncation of a stable system to r states: of the projections that the singular values
/// of the two Gramians' factors give.
class Reduction {
 public:
  explicit Reduction(const LinearSystem& system)
      : system_(system),
        reached_(factor(solve_stein(system.A.transpose(), system.B * system.B.transpose()))),
        seen_(factor(solve_stein(system.A, system.C.transpose() * system.C))),
        svd_(seen_.transpose() * reached_, Eigen::ComputeThinU | Eigen::ComputeThinV) {}

  LinearSystem to(Index r) const {
    const VectorXd root = svd_.singularValues().head(r).cwiseSqrt().cwiseInverse();
    const MatrixXd right = reached_ * svd_.matrixV().leftCols(r) * root.asDiagonal();
    const MatrixXd left =
        root.asDiagonal() * svd_.matrixU().leftCols(r).transpose() * seen_.transpose();
    return {left * system_.A * right, left * system_.B, system_.C * right, system_.D};
  }
  /// States that are more than rounding.
  Index rank() const {
    const VectorXd& s = svd_.singularValues();
    return (s.array() > 1e-10 * s(0)).count();
  }

 private:
  LinearSystem system_;
  MatrixXd reached_, seen_;
  Eigen::JacobiSVD<MatrixXd> svd_;
};

/// T, S - 1/2 and the complement C = F e_u / (1 - F e_u) by Q: T = T_0 + T_Q Q, and so on.
struct AffineMaps {
  VectorXcd T_0, T_Q, S_0, S_Q, C_0, C_Q;

  AffineMaps(const Observer& observer, const ModeResponses& at) {
    const LinearSystem none{MatrixXd::Zero(0, 0), MatrixXd::Zero(0, 1), MatrixXd::Zero(1, 0),
                            MatrixXd::Zero(1, 1)};
    // The law from (e, q) to (u, e - C x).
    const LinearSystem F = observer.law(none);
    LinearSystem innovation = F, command = F;
    innovation.C = -observer.C;
    innovation.D.setOnes();
    command.B = observer.B;
    command.D.setOnes();
    const VectorXcd F_0 = at.of(F);
    const VectorXcd loop = 1.0 - F_0.array() * at.e_u.array();
    const VectorXcd way =
        at.of(innovation).cwiseProduct(at.of(command)).array() / loop.array().square();
    T_0 = at.T(F_0);
    T_Q = way.array() * at.y_u.array() * at.e_w.array();
    S_0 = at.S(F_0).array() - 0.5;
    S_Q = way.cwiseProduct(at.sigma_f);
    C_0 = 1.0 / loop.array() - 1.0;
    C_Q = way.cwiseProduct(at.e_u);
  }
};

/// The least maximum for one mode.
class ModeProblem {
 public:
  ModeProblem(const SampledMode& mode, const ModeGoal& goal, const ModeResponses& at)
      : goal_(goal), at_(at), observer_(mode, goal), maps_(observer_, at) {
    change_ = (1.0 - at.z.array().inverse()).abs();
  }

  const Observer& observer() const { return observer_; }

  /// By what everything is off its bound: |T| / bound, alpha |S - 1/2| and, with `late`, that part
  /// of what one sample of delay changes, |1 - 1/z| |C|: less than one in all of it is enough.
  /// terms: N x n, what of Q is sought.
  Lawson with(const MatrixXcd& terms, double level_db, double late, double reserve) const {
    MatrixXcd M(3 * at_.hz.size(), terms.cols());
    for (Index i = 0; i < terms.cols(); ++i) {
      const auto times = [&](const VectorXcd& map) { return map.cwiseProduct(terms.col(i)); };
      M.col(i) = scaled(times(maps_.T_Q), times(maps_.S_Q), times(maps_.C_Q), level_db, late);
    }
    return {reserve * M, reserve * scaled(maps_.T_0, maps_.S_0, maps_.C_0, level_db, late)};
  }

 private:
  VectorXcd scaled(const VectorXcd& T, const VectorXcd& S, const VectorXcd& C, double level_db,
                   double late) const {
    VectorXcd all(3 * T.size());
    all << T.cwiseQuotient(bound_of(goal_, level_db, at_.hz).cast<Complex>()), goal_.disk * S,
        late * change_.cwiseProduct(C);
    return all;
  }

  ModeGoal goal_;
  const ModeResponses& at_;
  Observer observer_;
  AffineMaps maps_;
  VectorXd change_;
};

constexpr int lawson_steps = 160;
constexpr double lowest_db = 0, highest_db = 60, near_db = 0.4;

/// The lowest level at which the least maximum is one.
struct LevelSearch {
  double excluded_db = -infinity;  ///< no Q of the terms is below
  double reached_db = infinity;
  VectorXd x;  ///< that reaches it

  LevelSearch(const ModeProblem& problem, const MatrixXcd& terms, double late, double reserve) {
    const auto reaches = [&](double level_db) {
      Lawson lawson = problem.with(terms, level_db, late, reserve);
      lawson.run(lawson_steps, reserve);
      if (lawson.lower > reserve) excluded_db = std::max(excluded_db, level_db);
      if (!(lawson.upper <= 1)) return false;
      x = lawson.x();
      reached_db = level_db;
      return true;
    };
    double low = lowest_db, high = highest_db;
    if (!reaches(high)) return;
    if (reaches(low)) return;
    while (high - low > near_db) {
      const double middle = high - low > 16 ? low + 8 : (low + high) / 2;
      (reaches(middle) ? high : low) = middle;
    }
  }
};

/// What the states and the input of a system are, at every z: N x (n + 1).
MatrixXcd states_of(const LinearSystem& system, const VectorXcd& z) {
  const Index n = system.A.rows();
  MatrixXcd out(z.size(), n + 1);
  for (Index k = 0; k < z.size(); ++k) {
    MatrixXcd resolvent = -system.A.cast<Complex>();
    resolvent.diagonal().array() += z(k);
    out.row(k).head(n) = resolvent.partialPivLu().solve(system.B.cast<Complex>()).transpose();
    out(k, n) = 1;
  }
  return out;
}

/// The law of fewest states that does what x does, with C and D of the reduced Q sought anew.
std::optional<ModeLaw> reduced_law(const SampledMode& mode, const ModeGoal& goal,
                                   const ModeResponses& at, const ModeProblem& problem,
                                   const LinearSystem& Q, double level_db, double late) {
  // For what lies between the frequencies of the grid.
  constexpr double reserve = 1.003;
  const Reduction reduction(Q);
  for (Index r = 4; r <= std::min<Index>(reduction.rank(), 24); r += 2) {
    LinearSystem smaller = reduction.to(r);
    Lawson lawson = problem.with(states_of(smaller, at.z), level_db, late, reserve);
    lawson.run(lawson_steps, reserve);
    if (!(lawson.upper <= 1)) continue;
    const VectorXd x = lawson.x();
    smaller.C = x.head(r).transpose();
    smaller.D(0, 0) = x(r);
    ModeLaw law{.F = problem.observer().law(smaller)};
    law.disk = mode.disk_margin(law.F);
    law.level_db = level_of(goal, at.hz, at.T(at.of(law.F)));
    if (keeps(mode, goal, at, law)) return law;
  }
  return std::nullopt;
}

}  // namespace

MinimaxLaw minimax_mode_law(const SampledMode& mode, const ModeGoal& goal) {
  const ModeResponses at(mode, goal);
  const ModeProblem problem(mode, goal, at);
  const Basis basis(goal, mode.sampling().sample_time);
  const MatrixXcd terms = basis.at(at.z);
  // For the reduction.
  constexpr double reserve = 1.02;
  MinimaxLaw out;
  out.bound_db = LevelSearch(problem, terms, 0, 1).excluded_db;
  // The small gain that is enough for one more sample of delay is more than is needed, and a wider
  // disk keeps some of it, too: the first that keeps it, of each disk, and of those the best.
  for (const double wider : {1.0, 1.3, 1.7, 2.2, 3.0}) {
    ModeGoal kept = goal;
    kept.disk = wider * goal.disk;
    const ModeProblem of_kept(mode, kept, at);
    std::optional<ModeLaw> found;
    for (const double late : {0.5, 0.75, 1.0}) {
      const LevelSearch search(of_kept, terms, late, reserve);
      if (search.x.size() == 0) break;
      found = reduced_law(mode, kept, at, of_kept, basis.system(search.x), search.reached_db, late);
      if (!found) continue;
      if (!out.law || found->level_db < out.law->level_db) out.law = found;
      // With the least of them a wider disk costs isolation and wins nothing.
      if (late == 0.5) return out;
      break;
    }
  }
  return out;
}

}  // namespace stillframe

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <limits>
#include <numbers>

#include "core/mechanics/modes.hpp"
#include "plant_sim/nodal/consistent.hpp"
#include "tests/random_scenes/answers.hpp"

// The same frequencies from all coordinates of the nodes, with the conditions as constraints: no
// dofs, no transfer functions, other derivatives of the elements' forces.
namespace stillframe::random_scenes {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The scene's operating point, held.
class AtRest final : public Inputs {
 public:
  explicit AtRest(const MotionState& state, Index n_e)
      : state_(state), zero_(VectorXd::Zero(n_e)) {}
  void at(double, VectorXd& q_r, VectorXd& q_r_dot, VectorXd& q_r_ddot,
          VectorXd& sigma_a) const noexcept override {
    q_r = state_.q_r;
    q_r_dot = state_.q_r_dot;
    q_r_ddot = state_.q_r_ddot;
    sigma_a = zero_;
  }
  const VectorXd& external() const noexcept override { return none_; }

 private:
  const MotionState& state_;
  VectorXd zero_, none_;
};

/// M, K and damping of all free coordinates, and the constraint Jacobian D.
struct NodalMatrices {
  MatrixXd M, K, C, D;

  explicit NodalMatrices(Case& scene) {
    const Model& model = scene.model();
    nodal::Equations equations(model);
    nodal::Consistency consistency(equations);
    nodal::NodalState state = equations.zero_state();
    state.x = scene.operating_point().x;
    const AtRest inputs(scene.operating_point().state, model.n_e);
    equations.take_inputs(inputs, 0, state);
    equations.count_turns_from(state);
    if (!consistency.positions(state) || !consistency.accelerations(state)) {
      throw std::runtime_error("the nodal equations have no solution at the operating point");
    }
    const Index n = equations.n_free(), n_held = equations.n_held();
    equations.differentiate(state, true);
    MatrixXd mass(n + n_held, n), stiffness = mass, damping = mass;
    VectorXd r(n + n_held), back = r;
    const double speed = 2 * std::numbers::pi;
    for (Index j = 0; j < n; ++j) {
      r.setZero();
      equations.add_mass_product(VectorXd::Unit(n, j), r);
      mass.col(j) = r;
      r.setZero();
      equations.add_stiffness_product(1, VectorXd::Unit(n, j), r);
      stiffness.col(j) = r;
      // At rest the forces of rates are linear ones, of dampers, and squares, which differences of
      // two ways drop: no step is too long.
      state.x_dot(j) = speed;
      equations.residual(state, r);
      state.x_dot(j) = -speed;
      equations.residual(state, back);
      state.x_dot(j) = 0;
      damping.col(j) = (r - back) / (2 * speed);
    }
    M = mass.topRows(n);
    D = mass.bottomRows(n_held);
    K = stiffness.topRows(n);
    C = damping.topRows(n);
  }
};

}  // namespace

std::optional<Finding> check_frequencies(Case& scene, std::uint64_t) {
  // Nodes of a wheel go round: their equations are not constant.
  if (!scene.at_rest()) return std::nullopt;
  const VectorXd minimal =
      (2 * std::numbers::pi * modes(scene.linear()).natural_frequencies_hz).cwiseAbs2();
  // Loads that follow their nodes make the stiffness unsymmetric, and frequencies need not exist.
  if (minimal.size() == 0) return std::nullopt;
  const NodalMatrices nodal(scene);
  Finding finding;
  const Index n = nodal.M.rows(), n_d = n - nodal.D.rows();
  if (n_d != scene.model().n_d) {
    finding.take(1, 0, "number of free motions");
    return finding;
  }
  const Eigen::HouseholderQR<MatrixXd> factors(nodal.D.transpose());
  const MatrixXd Q = factors.householderQ();
  MatrixXd Z = Q.rightCols(n_d);
  const auto projected = [&Z](const MatrixXd& A) -> MatrixXd {
    const MatrixXd P = Z.transpose() * A * Z;
    return 0.5 * (P + P.transpose());
  };
  // Metres and radians, heavy and light: columns of Q that are orthogonal may be nearly one motion
  // to M, and the rounding of the whole is large beside what tells them apart. So these modes are a
  // basis only, whose breaches of the conditions go, and the modes are those found in it.
  Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(projected(nodal.K), projected(nodal.M));
  Z = Z * solver.eigenvectors();
  Z -= Q.leftCols(nodal.D.rows()) * factors.matrixQR()
                                        .topRows(nodal.D.rows())
                                        .transpose()
                                        .triangularView<Eigen::Lower>()
                                        .solve(nodal.D * Z);
  solver.compute(projected(nodal.K), projected(nodal.M));
  const MatrixXd M = projected(nodal.M);
  // Backward errors of eps in every entry of either matrix, and as many as there are additions.
  const double eps = 10 * static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  const VectorXd& minimal_rounding = own_answers(scene).squares_rounding;
  const MatrixXd V = (Z * solver.eigenvectors()).cwiseAbs(), K_sizes = nodal.K.cwiseAbs();
  const double nodal_rounding = (V.transpose() * K_sizes * V).diagonal().maxCoeff();
  for (Index i = 0; i < n_d; ++i) {
    finding.take(std::abs(solver.eigenvalues()(i) - minimal(i)),
                 eps * (minimal_rounding(i) + nodal_rounding),
                 "natural frequency " + std::to_string(i + 1), minimal(i));
  }
  // The sum of all decay rates; dampers of modes are not among those in nodal coordinates.
  double decay = M.ldlt().solve(projected(nodal.C)).trace();
  if (const auto& modal = scene.scene().modal_damping) {
    for (Index i = 0; i < n_d; ++i) {
      const double omega = std::sqrt(std::max(minimal(i), 0.0));
      decay += 2 * modal->ratio_at(omega / (2 * std::numbers::pi)) * omega;
    }
  }
  const double expected = scene.linear().M.ldlt().solve(scene.linear().damping()).trace();
  const double sizes = (V.transpose() * nodal.C.cwiseAbs() * V).trace();
  finding.take(std::abs(decay - expected),
               eps * (sizes + minimal_rounding.maxCoeff() / minimal.maxCoeff() * expected +
                      std::sqrt(minimal_rounding.maxCoeff())),
               "sum of decay rates", expected);
  return finding;
}

}  // namespace stillframe::random_scenes

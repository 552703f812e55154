#include "core/control/continuous_loop.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

LinearSystem continuous_loop(const LoopPlant& plant, const ForceFeedback& feedback) {
  const LinearSystem law = strain_feedback(feedback);
  const Index n = plant.A.rows(), n_law = law.A.rows(), m = plant.B_u.cols();
  const Index p = plant.B_w.cols(), n_y = plant.C_y.rows();
  LinearSystem loop;
  loop.A.resize(n + n_law, n + n_law);
  loop.A << plant.A + plant.B_u * law.D * plant.C_sigma, plant.B_u * law.C, law.B * plant.C_sigma,
      law.A;
  loop.B.resize(n + n_law, p + m);
  loop.B << plant.B_w, plant.B_u * law.D, MatrixXd::Zero(n_law, p), law.B;
  loop.C.resize(n_y, n + n_law);
  loop.C << plant.C_y + plant.D_yu * law.D * plant.C_sigma, plant.D_yu * law.C;
  loop.D.resize(n_y, p + m);
  loop.D << plant.D_yw, plant.D_yu * law.D;
  return loop;
}

Eigen::VectorXcd closed_loop_poles(const LoopPlant& plant, const ForceFeedback& feedback) {
  const LinearSystem loop = continuous_loop(plant, feedback);
  const Index total = loop.A.rows(), floor = plant.A.rows() - plant.n_exogenous;
  // The floor integrators move on their own: their rows hold nothing else.
  Eigen::VectorXi kept(total - plant.n_exogenous);
  for (Index i = 0; i < kept.size(); ++i) {
    kept(i) = static_cast<int>(i < floor ? i : i + plant.n_exogenous);
  }
  auto poles = eigenvalues(MatrixXd(loop.A(kept, kept)));
  if (!poles) throw Refusal("the poles of the continuous loop are not found");
  std::sort(poles->begin(), poles->end(), [](auto a, auto b) { return std::abs(a) < std::abs(b); });
  return *poles;
}

Decoupling decoupling(const MatrixXcd& T) {
  if (T.rows() != T.cols() || T.rows() == 0) {
    throw std::invalid_argument("decoupling: a square matrix is needed, got " +
                                std::to_string(T.rows()) + " x " + std::to_string(T.cols()));
  }
  const Eigen::VectorXd values = Eigen::JacobiSVD<MatrixXcd>(T).singularValues();
  Decoupling out{.spread_db = decibels(values(0) / values(values.size() - 1)),
                 .crosstalk_db = -infinity};
  for (Index j = 0; j < T.cols(); ++j) {
    const double own = std::norm(T(j, j)), others = T.col(j).squaredNorm() - own;
    if (others > 0) out.crosstalk_db = std::max(out.crosstalk_db, 10 * std::log10(others / own));
  }
  return out;
}

}  // namespace stillframe

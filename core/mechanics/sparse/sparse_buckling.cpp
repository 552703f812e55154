#include "core/mechanics/sparse/sparse_buckling.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/unsymmetric_load.hpp"
#include "core/numerics/lanczos.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

Buckling sparse_buckling(const MixedModel& mixed, Index n_shapes) {
  const VectorXd x = mixed.written(1), c = mixed.compliance();
  const VectorXd f = mixed.forces(x, 1);
  if (f.isZero(0) && mixed.model().preload.isZero(0)) {
    throw Refusal("there is no load to multiply: add loads, gravity or preloads");
  }
  if (!mixed.model().turning_loads.empty()) {
    throw Refusal("the geometric stiffness is not symmetric, as " +
                  unsymmetric_load(mixed.model()) +
                  ": such a load has no buckling multiplier; follow the modes under growing load "
                  "instead");
  }
  const SparseMatrix E = mixed.strain_rows(x);
  MixedFactors<double> K;
  if (!K.compute(E, c, SparseMatrix(E.cols(), E.cols()))) {
    throw Refusal(
        "the stiffness matrix of the unloaded scene is not positive definite: it can move "
        "without strain, or has dofs that nothing resists");
  }
  VectorXd s, displacement;
  K.solve({}, f, s, displacement);
  const SparseMatrix G = mixed.geometric_stiffness(x, s, 1);
  Buckling result;
  result.q_names = coordinate_names(mixed.model());
  if (G.nonZeros() == 0) return result;
  // -G v = v K / lambda: the smallest multipliers are the largest eigenvalues.
  VectorXd e;
  const LanczosPairs pairs = largest_pairs(
      SparseMatrix(-G), n_shapes, Largest::algebraic,
      [&](const VectorXd& f_v, VectorXd& y) { K.solve({}, f_v, s, y); },
      [&](const VectorXd& v, VectorXd& y) {
        e.noalias() = E * v;
        for (Index i = 0; i < e.size(); ++i) e(i) = c(i) != 0 ? e(i) / c(i) : 0;
        y.noalias() = E.transpose() * e;
      });
  if (!pairs.converged) {
    throw Refusal("the load multipliers were not found: the Lanczos method did not converge");
  }
  const Index n_found = pairs.values.size();
  const double threshold = n_found > 0 ? 1e-13 * pairs.values.cwiseAbs().maxCoeff() : 0;
  const Index count = (pairs.values.array() > threshold).count();
  result.load_multipliers = pairs.values.head(count).cwiseInverse();
  result.shapes = pairs.vectors.leftCols(count);
  for (auto shape : result.shapes.colwise()) {
    Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    shape /= shape(largest);
  }
  return result;
}

}  // namespace stillframe

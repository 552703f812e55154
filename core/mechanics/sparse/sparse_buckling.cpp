#include "core/mechanics/sparse/sparse_buckling.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/sparse/unresisted.hpp"
#include "core/numerics/lanczos.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

Buckling sparse_buckling(const MixedModel& mixed, Index n_shapes) {
  const VectorXd x = mixed.written(1), f = mixed.forces(x, 1);
  if (f.isZero(0) && mixed.model().preload.isZero(0)) refuse_without_load();
  const SparseMatrix E = mixed.strain_rows(x);
  MixedFactors<double> K;
  const SparseMatrix nothing(E.cols(), E.cols());
  if (!K.compute(E, mixed.compliance(), nothing)) {
    refuse_free_to_move(unresisted_coordinate(mixed, E, nothing));
  }
  VectorXd s, displacement;
  K.solve({}, f, s, displacement);
  const SparseMatrix G = mixed.geometric_stiffness({x, s, 1});
  Buckling result;
  result.q_names = coordinate_names(mixed.model());
  if (G.nonZeros() == 0) return result;
  // -G v = v K / lambda: the smallest multipliers are the largest eigenvalues.
  const LanczosPairs pairs = largest_pairs(
      SparseMatrix(-G), n_shapes, Largest::algebraic,
      [&](const VectorXd& f_v, VectorXd& y) { K.solve({}, f_v, s, y); },
      [&](const VectorXd& v, VectorXd& y) {
        const VectorXd sigma = mixed.stiffness().cwiseProduct(E * v);
        y.noalias() = E.transpose() * sigma;
      });
  if (!pairs.converged) {
    throw Refusal("the load multipliers were not found: the Lanczos method did not converge");
  }
  const Index n_found = pairs.values.size();
  const double threshold = n_found > 0 ? 1e-13 * pairs.values.cwiseAbs().maxCoeff() : 0;
  const Index count = (pairs.values.array() > threshold).count();
  result.load_multipliers = pairs.values.head(count).cwiseInverse();
  result.shapes = pairs.vectors.leftCols(count);
  scale_to_largest(result.shapes);
  return result;
}

}  // namespace stillframe

#include "core/mechanics/sparse/unresisted.hpp"

#include <cmath>

#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

std::string unresisted_coordinate(const MixedModel& mixed, const SparseMatrix& E,
                                  const SparseMatrix& A) {
  VectorXd diagonal = E.cwiseAbs2().transpose() * mixed.stiffness() + A.diagonal();
  const double most = diagonal.maxCoeff();
  diagonal = (diagonal.array() > 0).select(diagonal, most > 0 ? most : 1.0);
  const VectorXd weight = diagonal.cwiseSqrt();
  VectorXd x(diagonal.size()), s;
  for (Index i = 0; i < x.size(); ++i) x(i) = 1 + 0.5 * std::sin(1.7 * static_cast<double>(i));
  MixedFactors<double> factors;
  // On a small foundation what nothing resists moves farthest; on a smaller one, what is soft as
  // well: a chain of 1000 beams is 1e-12 as stiff as one.
  for (const double foundation : {1e-9, 1e-12, 1e-15}) {
    SparseMatrix founded(A.rows(), A.cols());
    founded.setIdentity();
    founded = founded * VectorXd(foundation * diagonal).asDiagonal();
    founded += A;
    if (!factors.compute(E, mixed.compliance(), founded)) return "";
    constexpr int steps = 20;
    double grown = 0;
    for (int k = 0; k < steps; ++k) {
      const VectorXd force = diagonal.cwiseProduct(x);
      factors.solve({}, force, s, x);
      grown = weight.cwiseProduct(x).norm();
      if (!std::isfinite(grown) || grown == 0) return "";
      x /= grown;
    }
    // What resists a thousandth of the foundation more is rounding.
    if (grown * foundation < 0.999) continue;
    Index largest = 0;
    weight.cwiseProduct(x.cwiseAbs()).maxCoeff(&largest);
    return coordinate_names(mixed.model())[static_cast<size_t>(largest)];
  }
  return "";
}

}  // namespace stillframe

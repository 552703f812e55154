#include "core/mechanics/bodies/reduced_body.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/errors/input_error.hpp"
#include "core/mechanics/elements/element.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/numerics/lanczos.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

/// Which degrees of freedom the interfaces have, and how a unit of each of their motions moves
/// them.
struct Boundary {
  std::vector<bool> taken;  ///< a degree of freedom of the mesh
  std::vector<Eigen::Triplet<double>> motions;
  Eigen::Matrix3Xd points;
};

Boundary boundary_of(const FiniteElementBody& body, const std::vector<BodyInterface>& interfaces) {
  if (interfaces.empty()) throw InputError(body.name + ": at least one interface is needed");
  Boundary boundary;
  boundary.taken.assign(static_cast<std::size_t>(body.K.rows()), false);
  boundary.points.resize(3, static_cast<Index>(interfaces.size()));
  for (std::size_t k = 0; k < interfaces.size(); ++k) {
    const BodyInterface& interface = interfaces[k];
    const std::set<long> nodes(interface.nodes.begin(), interface.nodes.end());
    const auto fail = [&](long node, const std::string& why) {
      return InputError("interface '" + interface.name + "': node " + std::to_string(node) + " " +
                        why);
    };
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const long node : nodes) {
      if (!body.nodes.contains(node)) throw fail(node, "is not in the mesh");
      middle += body.nodes.at(node) / static_cast<double>(nodes.size());
    }
    const Eigen::Vector3d point = interface.point.value_or(middle);
    boundary.points.col(static_cast<Index>(k)) = point;
    for (const long node : nodes) {
      const auto rows = body.rows.find(node);
      if (rows == body.rows.end()) throw fail(node, "has no degree of freedom");
      Eigen::Matrix<double, 3, 6> motion;
      motion << Eigen::Matrix3d::Identity(), -cross_matrix(body.nodes.at(node) - point);
      for (Index axis = 0; axis < 3; ++axis) {
        const Index row = rows->second[static_cast<std::size_t>(axis)];
        if (row < 0) throw fail(node, "is held along an axis: the body has to be free");
        if (boundary.taken[static_cast<std::size_t>(row)]) {
          throw fail(node, "belongs to another interface as well");
        }
        boundary.taken[static_cast<std::size_t>(row)] = true;
        for (Index j = 0; j < 6; ++j) {
          boundary.motions.emplace_back(row, 6 * static_cast<Index>(k) + j, motion(axis, j));
        }
      }
    }
  }
  return boundary;
}

/// The columns of the identity whose rows are inside (not taken) or on the boundary.
Sparse selection(const std::vector<bool>& taken, bool on_boundary) {
  std::vector<Eigen::Triplet<double>> ones;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken[i] != on_boundary) continue;
    ones.emplace_back(static_cast<Index>(i), static_cast<Index>(ones.size()), 1.0);
  }
  Sparse columns(static_cast<Index>(taken.size()), static_cast<Index>(ones.size()));
  columns.setFromTriplets(ones.begin(), ones.end());
  return columns;
}

struct FreeModes {
  VectorXd squares;  ///< omega^2, rising, behind the six of rigid motion
  MatrixXd shapes;
};

/// The n lowest elastic modes of a body that nothing holds, seen from -shift: there K + shift M has
/// factors.
FreeModes lowest_free(const Sparse& K, const Sparse& M, double shift, Index n) {
  constexpr Index n_rigid = 6;
  const Sparse shifted = K + shift * M;
  Eigen::SimplicialLDLT<Sparse> factors(shifted);
  if (factors.info() != Eigen::Success) throw Refusal("the body has neither stiffness nor mass");
  const LanczosPairs pairs = largest_pairs(
      M, n_rigid + n, Largest::modulus,
      [&](const VectorXd& x, VectorXd& y) { y = factors.solve(x); },
      [&](const VectorXd& x, VectorXd& y) { y = shifted * x; });
  if (!pairs.converged) throw Refusal("the modes of the body did not converge");
  const Index found = std::max<Index>(pairs.values.size() - n_rigid, 0);
  return {pairs.values.tail(found).cwiseInverse().array() - shift, pairs.vectors.rightCols(found)};
}

/// The lowest omega^2 with all interfaces held: the size of what is looked for.
double lowest_held(const Sparse& M, const Eigen::SimplicialLDLT<Sparse>& factors, const Sparse& K) {
  const LanczosPairs pairs = largest_pairs(
      M, 1, Largest::modulus, [&](const VectorXd& x, VectorXd& y) { y = factors.solve(x); },
      [&](const VectorXd& x, VectorXd& y) { y = K * x; });
  if (pairs.values.size() == 0 || !(pairs.values(0) > 0)) {
    throw Refusal("between its interfaces the body has no mass");
  }
  return 1 / pairs.values(0);
}

/// Each column less what those before it have of it, in K; columns of which next to nothing is left
/// are dropped.
MatrixXd orthogonal(const Sparse& K, MatrixXd columns) {
  Index n = 0;
  for (Index i = 0; i < columns.cols(); ++i) {
    VectorXd shape = columns.col(i);
    const double before = shape.dot(K * shape);
    for (int twice = 0; twice < 2; ++twice) {
      for (Index j = 0; j < n; ++j) {
        const VectorXd force = K * columns.col(j);
        shape -= columns.col(j) * (force.dot(shape) / force.dot(columns.col(j)));
      }
    }
    // A shape that the others have to a millionth is theirs.
    if (!(shape.dot(K * shape) > 1e-12 * before)) continue;
    Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    columns.col(n++) = shape / shape(largest);
  }
  return columns.leftCols(n);
}

double hz(double square) { return std::sqrt(square) / two_pi; }

}  // namespace

ReducedBody reduce_body(const FiniteElementBody& body, const std::vector<BodyInterface>& interfaces,
                        const KeptModes& kept,
                        const std::function<void(const std::string&)>& stage) {
  const Boundary boundary = boundary_of(body, interfaces);
  const Index n = static_cast<Index>(interfaces.size()), n_boundary = 6 * n;
  const Index most =
      std::min<Index>(max_deformations - (n_boundary - 6), (max_local - 7 * n) / 3 * 3);
  if (most < 0) {
    throw InputError(body.name + ": found " + std::to_string(n) +
                     " interfaces, allowed are up to " + std::to_string(max_local / 7));
  }
  Sparse T(body.K.rows(), n_boundary);
  T.setFromTriplets(boundary.motions.begin(), boundary.motions.end());
  const Sparse inside = selection(boundary.taken, false);
  const Sparse K = inside.transpose() * body.K * inside, M = inside.transpose() * body.M * inside;
  const Index n_inside = K.rows(), allowed = std::min(most, n_inside);
  const auto too_many = [&](const std::string& found) {
    return InputError(body.name + ": found " + found + ", allowed with " + std::to_string(n) +
                      " interfaces are up to " + std::to_string(allowed));
  };
  if (kept.n_modes > allowed) throw too_many(std::to_string(kept.n_modes) + " modes");
  const auto reduced_in = [&](const MatrixXd& basis, Index n_modes) {
    FlexibleBody found;
    found.points = boundary.points;
    found.n_modes = n_modes;
    for (const BodyInterface& interface : interfaces) found.interfaces.push_back(interface.name);
    const auto reduce = [&](const Sparse& matrix) {
      const MatrixXd product = basis.transpose() * (matrix * basis);
      return MatrixXd(0.5 * (product + product.transpose()));
    };
    found.M = reduce(body.M);
    found.K = reduce(body.K);
    // What moves no interface does not work on static shapes: what is there is rounding.
    found.K.topRightCorner(n_boundary, n_modes).setZero();
    found.K.bottomLeftCorner(n_modes, n_boundary).setZero();
    // A single interface moves the whole body as one rigid piece, unless something holds that.
    if (n_boundary == 6) {
      const MatrixXd moves = basis.leftCols<6>().cwiseAbs(),
                     sizes = moves.transpose() * (body.K.cwiseAbs() * moves);
      auto block = found.K.topLeftCorner<6, 6>();
      if ((block.cwiseAbs().array() <= 1e-9 * sizes.array()).all()) block.setZero();
    }
    return found;
  };
  // Nothing but interfaces: rigid pieces, and what is between them.
  if (n_inside == 0)
    return {.body = reduced_in(MatrixXd(T), 0), .frequencies_hz = {}, .first_left_out_hz = {}};

  stage("factors of the inside");
  Eigen::SimplicialLDLT<Sparse> factors;
  factors.compute(K);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) {
    throw InputError(body.name +
                     ": with all interfaces held the body can still move without stiffness: a part "
                     "is not joined, or all nodes of an interface lie on one line");
  }
  stage("static shapes");
  MatrixXd basis(T);
  const MatrixXd loads = inside.transpose() * (body.K * basis);
  basis -= inside * MatrixXd(factors.solve(loads));

  stage("modes of the free body");
  // Coordinates: what is inside, then the six of each interface.
  Sparse moves(body.K.rows(), n_inside + n_boundary);
  moves.leftCols(n_inside) = inside;
  moves.rightCols(n_boundary) = T;
  const Sparse K_free = moves.transpose() * body.K * moves,
               M_free = moves.transpose() * body.M * moves;
  // One more than is kept says what the next would have been.
  const Index asked = std::min(n_inside, kept.to_hz ? allowed : kept.n_modes) + 1;
  const FreeModes free = lowest_free(K_free, M_free, lowest_held(M, factors, K), asked);
  ReducedBody reduced;
  Index n_modes = std::min(kept.n_modes, free.squares.size());
  if (kept.to_hz) {
    n_modes = 0;
    while (n_modes < free.squares.size() && hz(free.squares(n_modes)) <= *kept.to_hz) ++n_modes;
    if (n_modes > allowed) {
      throw too_many("more than " + std::to_string(allowed) + " modes up to " +
                     shortest_digits(*kept.to_hz) + " Hz");
    }
  }
  if (n_modes < free.squares.size()) reduced.first_left_out_hz = hz(free.squares(n_modes));
  reduced.frequencies_hz = free.squares.head(n_modes).unaryExpr(&hz);

  const MatrixXd left =
      free.shapes.topLeftCorner(n_inside, n_modes) -
      (inside.transpose() * basis) * free.shapes.bottomLeftCorner(n_boundary, n_modes);
  const MatrixXd amplitudes = orthogonal(K, left);
  n_modes = amplitudes.cols();
  basis.conservativeResize(Eigen::NoChange, n_boundary + n_modes);
  basis.rightCols(n_modes) = inside * amplitudes;

  reduced.body = reduced_in(basis, n_modes);
  return reduced;
}

}  // namespace stillframe

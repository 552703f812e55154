#include "tests/random_scenes/answers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"
#include "judge/scene_design.hpp"

namespace stillframe::random_scenes {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

namespace {

double condition(const MatrixXd& A) {
  const auto values = Eigen::BDCSVD<MatrixXd>(A).singularValues();
  return values(0) / values(values.size() - 1);
}

/// Of a mass matrix, whatever units its dofs have.
double scaled_condition(const MatrixXd& M) {
  const VectorXd d = M.diagonal().cwiseSqrt().cwiseInverse();
  return condition(d.asDiagonal() * M * d.asDiagonal());
}

/// The parts of G(s) = Y Z^-1 B + D of a linear model, as transfer_function puts them together.
struct Parts {
  MatrixXcd Y, Z, B, D;

  Parts(const LinearModel& l, Complex s)
      : Y(l.Y_p + s * l.Y_v + s * s * l.Y_a), Z(s * s * l.M + s * l.damping() + l.stiffness()) {
    B = l.B.cast<Complex>();
    D = l.D_u.cast<Complex>();
    for (Index j = 0; j < B.cols(); ++j) {
      const Quantity quantity = l.inputs[static_cast<size_t>(j)].quantity;
      if (!is_motion(quantity)) continue;
      const auto kind = input_kind(quantity);
      const Complex w = kind == InputColumns::Kind::position   ? 1.0
                        : kind == InputColumns::Kind::velocity ? 1.0 / s
                                                               : 1.0 / (s * s);
      B.col(j) = -w * (s * s * l.M_r.col(j) + s * l.damping_r().col(j) + l.stiffness_r().col(j));
      D.col(j) = w * (l.R_p.col(j) + s * l.R_v.col(j) + s * s * l.R_a.col(j));
    }
  }
};

/// Motions of unit kinetic energy. The longest of a node, translations and rotations: a force or a
/// signal that has no lever has the rounding of the longest.
struct Levers {
  double translation = 0, rotation = 0;
  double mass = 0;  ///< rounding of M, of unit kinetic energy, for one eps

  Levers(const Model& model, const VectorXd& x, const MatrixXd& L) {
    Data data(model);
    data.x = x;
    geometric_transfer_functions(model, data);
    // n_x x n_d
    const MatrixXd moves = L.triangularView<Eigen::Lower>().solve(data.DF.transpose()).transpose();
    for (const ModelNode& node : model.nodes) {
      for (const PartMap* map : {&node.translation, &node.rotation}) {
        double& longest = map == &node.translation ? translation : rotation;
        for_each_column({*map}, model.n_x, [&](Index, Index column) {
          longest = std::max(longest, (map->size == 4 ? 2 : 1) * moves.row(column).norm());
        });
      }
    }
    // Every entry of an inertia's mass carries eps of the largest that its two parts have: about
    // the axis of a slim body a small inertia is a difference of large ones.
    LocalVector u;
    LocalHessian M;
    for (const ModelInertia& item : model.inertias) {
      M.resize(item.inertia->n_local(), item.inertia->n_local());
      gather(item.parts, data.x, u);
      item.inertia->mass(u, M);
      std::vector<double> moved;
      for (const PartMap& map : item.parts) {
        double squares = 0;
        for_each_column({map}, model.n_x,
                        [&](Index, Index column) { squares += moves.row(column).squaredNorm(); });
        moved.push_back(std::sqrt(squares));
      }
      Index row = 0;
      for (size_t p = 0; p < item.parts.size(); row += item.parts[p++].size) {
        Index column = 0;
        for (size_t q = 0; q < item.parts.size(); column += item.parts[q++].size) {
          mass +=
              moved[p] * moved[q] *
              M.block(row, column, item.parts[p].size, item.parts[q].size).cwiseAbs().maxCoeff();
        }
      }
    }
  }
  double of(Quantity quantity, Complex s) const {
    switch (quantity) {
      case Quantity::position:
      case Quantity::force:
        return translation;
      case Quantity::velocity:
        return translation * std::abs(s);
      case Quantity::acceleration:
        return translation * std::norm(s);
      case Quantity::rotation:
      case Quantity::torque:
        return rotation;
      case Quantity::angular_velocity:
        return rotation * std::abs(s);
      case Quantity::angular_acceleration:
        return rotation * std::norm(s);
      default:
        return 0;
    }
  }
};

/// Backward errors of eps of Z, B and Y in the dofs, whose rounding is that of M, and of eps of
/// the largest term that D stands beside, go through Z^-1 to G.
MatrixXd rounding_of(const LinearModel& l, const Levers& levers, Complex s, double mass_rounding) {
  const Parts parts(l, s);
  const MatrixXd L = Eigen::LLT<MatrixXd>(l.M).matrixL();
  const auto solve_left = [&](const MatrixXcd& A) -> MatrixXcd {
    return L.cast<Complex>().triangularView<Eigen::Lower>().solve(A);
  };
  const MatrixXcd Z = solve_left(solve_left(parts.Z).transpose()).transpose();
  const auto values = Eigen::JacobiSVD<MatrixXcd>(Z).singularValues();
  const double smallest = values(values.size() - 1), kappa = values(0) / smallest;
  VectorXd y = solve_left(parts.Y.transpose()).colwise().norm(),
           b = solve_left(parts.B).colwise().norm();
  for (Index i = 0; i < y.size(); ++i) {
    y(i) = std::max(y(i), levers.of(l.outputs[static_cast<size_t>(i)].quantity, s));
  }
  for (Index j = 0; j < b.size(); ++j) {
    b(j) = std::max(b(j), levers.of(l.inputs[static_cast<size_t>(j)].quantity, s));
  }
  return mass_rounding * kappa * (y * b.transpose() / smallest + parts.D.cwiseAbs());
}

/// Of the squares of the natural frequencies, for one eps: |d omega^2| <= v^T (|dK| + omega^2 |dM|)
/// v for shapes v of unit mass. Sums over elements and Cholesky's factors are off by eps of the
/// diagonal entries, sqrt(K_ii K_jj); directions of elements and singular values, which are omega,
/// by eps of the highest; and none by more than eps of the highest square.
VectorXd squares_rounding(const LinearModel& l, const Modes& found, const VectorXd& squares,
                          double mass_rounding) {
  const auto of = [&found](const MatrixXd& A) -> VectorXd {
    const VectorXd sizes = A.diagonal().cwiseAbs().cwiseSqrt();
    return (found.shapes.cwiseAbs().transpose() * sizes).cwiseAbs2();
  };
  const VectorXd omega = squares.cwiseAbs().cwiseSqrt();
  const VectorXd each = of(l.stiffness()) + of(l.M).cwiseProduct(squares.cwiseAbs()) +
                        mass_rounding * (squares.cwiseAbs() + 2 * omega.maxCoeff() * omega);
  return each.cwiseMin(mass_rounding * squares.maxCoeff());
}

/// How far what is out of balance at the operating point moves a node, over the shortest element.
double misplaced(const Scene& scene, const Model& model, const NominalMotion& nominal,
                 const LinearModel& linear) {
  Data data(model);
  nominal.place(data);
  VectorXd f;
  if (!out_of_balance(model, data, nominal, f)) return 1;
  return largest_move(model, data.DF * motion_against(linear.stiffness(), f)) * scene_size(model) /
         shortest_element(scene);
}

}  // namespace

double shortest_element(const Scene& scene) {
  double least = std::numeric_limits<double>::infinity();
  const auto at = [&](const std::string& name) {
    return std::find_if(scene.nodes.begin(), scene.nodes.end(),
                        [&](const SceneNode& node) { return node.name == name; })
        ->position;
  };
  for (const SceneElement& element : scene.elements) {
    const double length = (at(element.node_p) - at(element.node_q)).norm();
    if (length > 0) least = std::min(least, length);
  }
  return least;
}

std::vector<Complex> places(Case& scene) {
  const VectorXd f = modes(scene.linear()).eigenvalues.cwiseAbs();
  const double highest = f.maxCoeff();
  double lowest = highest;
  for (const double omega : f) {
    if (omega > 1e-7 * highest) lowest = std::min(lowest, omega);  // a free motion has none
  }
  const Complex direction = std::polar(1.0, std::numbers::pi / 3);
  return {0.7 * lowest * direction, std::sqrt(lowest * highest) * direction,
          1.3 * highest * direction};
}

Answers answers(const Scene& scene, const std::vector<Complex>& at) {
  const Model model = make_model(scene);
  const NominalMotion nominal = nominal_motion(model);
  const LinearModel linear = linearise(model, nominal, scene.inputs, scene.outputs);
  Answers out;
  out.misplaced = misplaced(scene, model, nominal, linear);
  const Modes found = modes(linear);
  const Levers levers(model, linear.x_0, Eigen::LLT<MatrixXd>(linear.M).matrixL());
  // Of forming M, and of solving with it.
  const double mass_rounding = levers.mass + scaled_condition(linear.M);
  out.squares = (2 * std::numbers::pi * found.natural_frequencies_hz).cwiseAbs2();
  if (out.squares.size() > 0) {
    out.squares_rounding = squares_rounding(linear, found, out.squares, mass_rounding);
  }
  for (const Complex s : at) {
    out.responses.push_back(
        {transfer_function(linear, s), rounding_of(linear, levers, s, mass_rounding)});
  }
  if (!scene.controller) return out;
  const judge::LoopDesign design = judge::make_loop_design(scene);
  out.K_P = design.gains.K_P;
  out.K_I = design.gains.K_I;
  const LegMatrices& legs = design.loop.design.legs;
  out.gains_rounding = condition(legs.M) * condition(legs.K) * mass_rounding;
  // Fewer legs than dofs: the motion that stands for them comes of K^-1, or of modes.
  if (legs.M.rows() < model.n_d) {
    const MatrixXd inverse =
        Eigen::LLT<MatrixXd>(linear.M).matrixL().solve(MatrixXd::Identity(model.n_d, model.n_d));
    out.gains_rounding *= condition(inverse * linear.stiffness() * inverse.transpose());
  }
  out.radius = design.radius;
  return out;
}

const Answers& own_answers(Case& scene) {
  if (!scene.answers) {
    scene.answers = std::make_shared<const Answers>(answers(scene.scene(), places(scene)));
  }
  return *scene.answers;
}

double Units::of(const SceneSignal& signal, const Scene& scene) const {
  const double force = mass * length / (time * time), moment = force * length;
  const bool hinge =
      std::any_of(scene.elements.begin(), scene.elements.end(), [&](const auto& element) {
        return element.name == signal.element && element.kind == SceneElement::Kind::hinge;
      });
  const double deformation = hinge ? 1 : length;
  switch (signal.quantity) {
    case Quantity::position:
      return length;
    case Quantity::velocity:
      return length / time;
    case Quantity::acceleration:
      return length / (time * time);
    case Quantity::rotation:
      return 1;
    case Quantity::angular_velocity:
      return 1 / time;
    case Quantity::angular_acceleration:
      return 1 / (time * time);
    case Quantity::force:
    case Quantity::reaction:
      return force;
    case Quantity::torque:
    case Quantity::reaction_moment:
      return moment;
    case Quantity::stress:
      return hinge ? moment : force;
    case Quantity::deformation:
      return deformation;
    case Quantity::deformation_rate:
      return deformation / time;
    case Quantity::deformation_acceleration:
      return deformation / (time * time);
  }
  return 1;
}

Finding compare(const Scene& scene, const Answers& a, const Answers& b, double eps,
                const Units& units) {
  Finding finding;
  const double per_square = units.time * units.time;
  // Some ten times what is seen to be left: it was found from there.
  const double misplaced = 10 * (a.misplaced + b.misplaced);
  if (a.squares.size() != b.squares.size()) {
    finding.take(1, 0, "number of natural frequencies");
    return finding;
  }
  for (Index i = 0; i < a.squares.size(); ++i) {
    const double scale = eps * (a.squares_rounding(i) + b.squares_rounding(i) * per_square) +
                         misplaced * a.squares.maxCoeff();
    finding.take(std::abs(a.squares(i) - b.squares(i) * per_square), scale,
                 "natural frequency " + std::to_string(i + 1), a.squares(i));
  }
  for (size_t k = 0; k < a.responses.size(); ++k) {
    const Response &p = a.responses[k], &q = b.responses[k];
    for (Index i = 0; i < p.G.rows(); ++i) {
      for (Index j = 0; j < p.G.cols(); ++j) {
        const SceneSignal &input = scene.inputs[static_cast<size_t>(j)],
                          &output = scene.outputs[static_cast<size_t>(i)];
        const double factor = units.of(input, scene) / units.of(output, scene);
        finding.take(
            std::abs(p.G(i, j) - q.G(i, j) * factor),
            eps * (p.rounding(i, j) + q.rounding(i, j) * factor) + misplaced * std::abs(p.G(i, j)),
            "transfer function from " + input.name + " to " + output.name, std::abs(p.G(i, j)));
      }
    }
  }
  if (a.K_P.size() == 0) return finding;
  const double gains = eps * (a.gains_rounding + b.gains_rounding) + misplaced;
  const double K_P = a.K_P.cwiseAbs().maxCoeff(), K_I = a.K_I.cwiseAbs().maxCoeff();
  finding.take((a.K_P - b.K_P).cwiseAbs().maxCoeff(), gains * (1 + K_P), "K_P", K_P);
  finding.take((a.K_I - b.K_I * units.time).cwiseAbs().maxCoeff(), gains * K_I, "K_I", K_I);
  // A double pole moves by the root of what its matrix does.
  finding.take(std::abs(a.radius - b.radius), std::sqrt(gains) * a.radius, "spectral radius",
               a.radius);
  return finding;
}

}  // namespace stillframe::random_scenes

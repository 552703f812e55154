#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/systems/linear_system.hpp"

namespace stillframe {

struct SignalName {
  std::string name, unit;
};

/// Where one physical input stands among the columns of B and D. A direct input (a force, a stress)
/// has the one column `first`; a prescribed motion has three, first to first + 2, for its
/// acceleration, velocity and position, whichever of these the input itself is.
struct InputColumns {
  enum class Kind { direct, position, velocity, acceleration };
  Kind kind = Kind::direct;
  Eigen::Index first = 0;

  Eigen::Index width() const { return kind == Kind::direct ? 1 : 3; }
};

/// A linear input-output model about an operating point,
///   dx/dt = A x + B u,   y = C x + D u,   u = (..., w'', w', w, ...),
/// x: n states, y: p outputs, u: the columns of m physical inputs. A: n x n, B: n x columns,
/// C: p x n, D: p x columns. SI units. Source: deck, sections 8 to 10.
struct StateSpace {
  Eigen::MatrixXd A, B, C, D;
  std::vector<InputColumns> columns;        ///< one a physical input, m
  std::vector<SignalName> inputs;           ///< physical inputs, m
  std::vector<SignalName> outputs, states;  ///< p and n
  Eigen::VectorXd x0, u0, y0;               ///< operating point; may be empty
};

/// Plain matrices as a model without names whose inputs are all direct.
StateSpace proper_system(const LinearSystem& system);

/// Throws std::invalid_argument if the shapes do not match or an input's columns do not exist.
/// Empty lists of names, and an empty operating point, are allowed.
void check_shapes(const StateSpace& system);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// Modes of a linear model about its operating point. Natural frequencies and shapes solve
/// (K + N + G) v = omega^2 M v, sorted upwards, shapes mass-normalised (V^T M V = I, also where
/// frequencies repeat); they are empty where that has no meaning: K + N + G is not symmetric, or
/// the model moves and a square is negative. eigenvalues are those of the state matrix A, in n_d
/// neighbours sorted by modulus: a conjugate pair, positive imaginary part first, or two real ones.
/// What rounding does not tell from zero is 0.
/// damping_ratios are -Re / |.| of those pairs, 1 or -1 for real ones (that of the one that grows).
/// Source: deck, section 9.
struct Modes {
  Eigen::VectorXd natural_frequencies_hz;  ///< n_d or 0
  Eigen::VectorXd damping_ratios;          ///< n_d, 1
  Eigen::MatrixXd shapes;                  ///< n_d x n_d or 0 x 0
  Eigen::VectorXcd eigenvalues;            ///< 2 n_d, rad/s
  Eigen::VectorXd known_to;                ///< 2 n_d, rad/s, as of OwnValues
  bool moving = false;                     ///< C or N is not zero
  Eigen::Index n_growing = 0;              ///< eigenvalues with a real part above zero
};

/// Squares of the natural frequencies of (K + N + G)_sym v = omega^2 M v, upwards, below zero where
/// the stiffness is not positive, and mass-normalised shapes.
struct NaturalShapes {
  Eigen::VectorXd squares;   ///< n_d, rad^2/s^2
  Eigen::MatrixXd V;         ///< n_d x n_d
  Eigen::VectorXd known_to;  ///< n_d, rad/s, of their roots
};
/// Errors: Refusal if M is not positive definite.
NaturalShapes natural_shapes(const LinearModel& model);

/// Errors: Refusal if M is not positive definite, or if the model is at rest, its stiffness
/// symmetric, and a square of a natural frequency negative (not stable).
Modes modes(const LinearModel& model);

/// Writes damping_ratios and n_growing of eigenvalues and what they are known to; those that are
/// not told from zero become 0.
void judge_eigenvalues(Modes& modes);

/// Whether a disturbed operating point comes back or stays about, as modes() judges it: by the
/// stiffness alone where that decides, which asks for no mass.
struct Stability {
  std::optional<bool> stable;  ///< nothing where it is not known
  std::string why_not;         ///< a sentence without a full stop, empty unless it is not stable
  Eigen::VectorXd shape;       ///< n_d, what moves, or empty
};
Stability stability(const LinearModel& model);

}  // namespace stillframe

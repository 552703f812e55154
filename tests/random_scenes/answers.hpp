#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/mechanics/scene/scene.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

/// G(s) beside what rounding may do to it.
struct Response {
  Eigen::MatrixXcd G;        ///< n_y x n_u
  Eigen::MatrixXd rounding;  ///< n_y x n_u, for one eps
};

/// What a scene is asked that no choice of axes, order, units or coordinates may change.
struct Answers {
  Eigen::VectorXd squares;  ///< of the natural frequencies, 1/s^2; empty where there are none
  Eigen::VectorXd squares_rounding;  ///< 1/s^2, for one eps
  std::vector<Response> responses;
  Eigen::MatrixXd K_P, K_I;   ///< of the design, m x m, 1 and 1/s; empty without a loop
  double gains_rounding = 0;  ///< relative to the largest of them, for one eps
  double radius = 0;          ///< spectral radius of the sampled loop
  double misplaced = 0;       ///< error of the operating point, over the shortest element
};

/// Length of the shortest element that has one, m.
double shortest_element(const Scene& scene);

/// Complex frequencies (1/s) about the natural ones, damped by a half so that no resonance
/// magnifies rounding.
std::vector<std::complex<double>> places(Case& scene);

/// Errors: InputError and Refusal of the steps.
Answers answers(const Scene& scene, const std::vector<std::complex<double>>& at);
/// Those of the scene as it stands, at its places.
const Answers& own_answers(Case& scene);

/// Other units: a metre, a kilogram and a second are so many of them.
struct Units {
  double length = 1, mass = 1, time = 1;
  /// What one unit of a quantity is in the other ones. scene: where elements are looked up.
  double of(const SceneSignal& signal, const Scene& scene) const;
};

/// What of the answers differs. eps: to how much lengths are known, relative.
Finding compare(const Scene& scene, const Answers& a, const Answers& b, double eps,
                const Units& units = {});

}  // namespace stillframe::random_scenes

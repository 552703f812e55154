#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/control/own_law.hpp"

namespace stillframe::judge {

/// What a file of `law: FILE` brings: a sampled law, or gains.
struct LawFile {
  std::optional<NamedLaw> law;
  Eigen::MatrixXd K_P, K_I;              ///< without a law: m x m, 1 and 1/s
  std::optional<double> sample_rate_hz;  ///< always with a law
};

/// Reads it from its bytes. A name that ends on .mat: a level-5 file with A, B, C, D, Ts (s),
/// input_names and output_names, or a structure `law` of these, or K_P and K_I; on .yaml or .yml: a
/// map of A, B, C, D, sample_rate_hz, inputs and outputs, or of K_P and K_I. docs/design.md says
/// what each is. Errors: InputError of another name, of what is missing, of both or none of the
/// two, of numbers that are not finite or not of their range, and as read_mat.
LawFile read_law_file(const std::string& name, const std::string& bytes);

}  // namespace stillframe::judge

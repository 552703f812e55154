#pragma once

#include <memory>

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// A flexible body as files have it (docs/scene.md, superelements): how its interfaces and modes
/// move it.
struct FlexibleBody {
  std::vector<std::string> interfaces;
  Eigen::Matrix3Xd points;  ///< 3 x n, m: where the interfaces are, in the axes of the body
  Eigen::Index n_modes = 0;
  /// (6 n + n_modes)^2: of displacements (m) and small rotations (rad) of each interface, and of
  /// the modes' amplitudes (m).
  Eigen::MatrixXd M, K;
};

/// What is wrong with a body's matrix, empty if nothing is: K that is not zero in rigid motion and
/// positive in any other; M that is indefinite or not of one mass in every direction.
std::string stiffness_fault(const FlexibleBody& body);
std::string mass_fault(const FlexibleBody& body);

/// Reads the file whose path stands at `path`, and the two matrices that it names. Checks that they
/// are symmetric and a body's, and mass, centre of mass and inertia against those that the file
/// states. files becomes what was read. Errors: InputError naming the file and what is off.
FlexibleBody read_flexible_body(const YamlReader& path, std::vector<ReadFile>& files);

/// The text of such a file; the matrices are in files of these names beside it.
std::string flexible_body_text(const FlexibleBody& body, const std::string& title,
                               const std::string& mass_file, const std::string& stiffness_file);

/// Mass, centre of mass and inertia about it, in the axes of the body.
struct RigidProperties {
  double mass = 0;          ///< kg
  Eigen::Vector3d centre;   ///< m
  Eigen::Matrix3d inertia;  ///< kg m^2
};
RigidProperties rigid_properties(const FlexibleBody& body);

}  // namespace stillframe

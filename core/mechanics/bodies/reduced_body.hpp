#pragma once

#include <optional>

#include "core/mechanics/bodies/finite_element_body.hpp"
#include "core/mechanics/scene/body_file.hpp"

namespace stillframe {

/// Nodes of a mesh that move as one rigid piece, and the point whose displacement and rotation say
/// how.
struct BodyInterface {
  std::string name;
  std::vector<long> nodes;
  std::optional<Eigen::Vector3d> point;  ///< m; otherwise the middle of the nodes
};

/// How many modes of the free body are kept: so many, or all up to a frequency.
struct KeptModes {
  Eigen::Index n_modes = 0;
  std::optional<double> to_hz;
};

struct ReducedBody {
  FlexibleBody body;
  Eigen::VectorXd frequencies_hz;  ///< of the kept modes of the free body, rigid ones left out
  std::optional<double> first_left_out_hz;
};

/// The body in the span of its static shapes (unit displacements and rotations of each interface)
/// and of its lowest modes, free in space with each interface a rigid piece. Both it has exactly:
/// what soft legs do to it at rest, and how it moves by itself. Amplitudes are of the modes less
/// what the static shapes have of them, each less what those before it have (orthogonal in K), and
/// 1 m of one is 1 m of its largest displacement. Errors: InputError of interfaces that share
/// nodes, are held by the mesh or do not stop the body; of more modes than a superelement takes.
ReducedBody reduce_body(
    const FiniteElementBody& body, const std::vector<BodyInterface>& interfaces,
    const KeptModes& kept, const std::function<void(const std::string&)>& stage = [](auto&) {});

}  // namespace stillframe

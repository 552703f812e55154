#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/yaml/reader.hpp"
#include "plant_sim/floor/floor_source.hpp"

namespace stillframe::floor {

/// The motions of a rigid floor: along the world axes, and small rotations about them.
inline constexpr std::array<std::string_view, 6> axis_names = {"x", "y", "z", "rx", "ry", "rz"};

/// How a rigid floor moves, by its six motions at the origin, when it moves by one along an axis
/// (0 to 5, as axis_names) or turns by one about a line through a point (m).
///   u(r) = t + theta x r; about p: t = -theta x p
Eigen::VectorXd rigid_pattern(Eigen::Index axis, const Eigen::Vector3d& about);

/// What one course of motion moves: an axis of the rigid floor or an input of the scene.
struct Target {
  std::optional<Eigen::Index> axis;                 ///< 0 to 5
  Eigen::Index input = 0;                           ///< where there is no axis
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< m, of a rotation

  bool turns() const { return axis && *axis >= 3; }
  FloorChannels meaning() const { return axis ? FloorChannels::rigid : FloorChannels::inputs; }
  /// The channels of that meaning, inputs: number of floor inputs of the scene.
  Eigen::VectorXd pattern(Eigen::Index inputs) const;
};

/// The floor inputs of a scene, as floor blocks may refer to them: their number, and their names
/// where the caller knows them.
struct FloorInputs {
  Eigen::Index number = 0;
  std::vector<std::string> names;

  FloorInputs(Eigen::Index n) : number(n) {}
  FloorInputs(std::vector<std::string> all)
      : number(static_cast<Eigen::Index>(all.size())), names(std::move(all)) {}
};

/// The number (0 to 5) of an axis name.
Eigen::Index read_axis(const YamlReader& value);

/// The key `about` of a block, the origin without it; only a rotation is about anything.
Eigen::Vector3d read_about(const YamlReader& block, bool turns);

/// The keys `axis` or `input`, and `about`, of a block. Errors: InputError unless it has exactly
/// one of the first two.
Target read_target(const YamlReader& block, const FloorInputs& inputs);

}  // namespace stillframe::floor

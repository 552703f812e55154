#include "plant_sim/floor/target.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace stillframe::floor {

Eigen::VectorXd rigid_pattern(Eigen::Index axis, const Eigen::Vector3d& about) {
  Eigen::VectorXd pattern = Eigen::VectorXd::Zero(6);
  pattern(axis) = 1.0;
  if (axis >= 3) pattern.head<3>() = -Eigen::Vector3d::Unit(axis - 3).cross(about);
  return pattern;
}

Eigen::VectorXd Target::pattern(Eigen::Index inputs) const {
  return axis ? rigid_pattern(*axis, about) : Eigen::VectorXd::Unit(inputs, input);
}

Eigen::Index read_axis(const YamlReader& value) {
  const std::string name = value.one_of({"x", "y", "z", "rx", "ry", "rz"});
  return std::find(axis_names.begin(), axis_names.end(), name) - axis_names.begin();
}

Eigen::Vector3d read_about(const YamlReader& block, bool turns) {
  const auto value = block.find("about");
  if (!value) return Eigen::Vector3d::Zero();
  if (!turns) value->fail("only the rotations rx, ry and rz are about a point");
  return value->vector(3);
}

Target read_target(const YamlReader& block, const FloorInputs& inputs) {
  const auto axis = block.find("axis"), input = block.find("input");
  if (axis.has_value() == input.has_value()) {
    block.fail("needs either 'axis' (x, y, z, rx, ry or rz) or 'input' (the name of an input)");
  }
  Target target;
  if (axis) {
    target.axis = read_axis(*axis);
  } else {
    const std::string name = input->text();
    const auto found = std::find(inputs.names.begin(), inputs.names.end(), name);
    if (found == inputs.names.end()) {
      const std::string near = nearest_name(name, inputs.names);
      input->fail("there is no input named '" + name + "'" +
                  (near.empty() ? "" : "; the nearest name is '" + near + "'"));
    }
    target.input = found - inputs.names.begin();
  }
  target.about = read_about(block, target.turns());
  return target;
}

}  // namespace stillframe::floor

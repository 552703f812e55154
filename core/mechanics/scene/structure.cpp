#include "core/mechanics/scene/structure.hpp"

#include "core/mechanics/scene/constraints.hpp"
#include "core/mechanics/scene/dofs.hpp"
#include "core/mechanics/scene/elements.hpp"
#include "core/mechanics/scene/nodes_masses.hpp"
#include "core/mechanics/scene/references.hpp"

namespace stillframe {

void read_structure(const YamlReader& root, Scene& scene) {
  if (const auto value = root.find("planar")) scene.planar = value->boolean();
  if (const auto value = root.find("gravity")) scene.gravity = read_vector(*value, scene);
  if (const auto value = root.find("operating_point")) {
    const std::string word = value->one_of({"equilibrium", "as_written"});
    scene.operating_point =
        word == "as_written" ? OperatingPoint::as_written : OperatingPoint::equilibrium;
  }
  read_nodes(root.require("nodes"), scene);
  // The elements come before all that may refer to the nodes of divided beams.
  read_elements(root.require("elements"), scene);
  read_masses(root.require("masses"), scene);
  if (const auto list = root.find("supports")) read_supports(*list, scene);
  if (const auto list = root.find("prescribed")) read_prescribed(*list, scene);
  read_dofs(root.require("dofs"), scene);
  if (const auto list = root.find("loads")) read_loads(*list, scene);
}

}  // namespace stillframe

#include "core/mechanics/scene/dofs.hpp"

#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

void refuse(const YamlReader& map, const char* key, const std::string& why) {
  if (const auto given = map.find(key)) given->fail(why);
}

[[noreturn]] void fail_rigid(const YamlReader& value, const SceneElement& element, int mode) {
  if (element.rigid()) {
    value.fail("'" + element.name + "' is rigid, its deformation can be no dof");
  }
  value.fail("deformation " + std::to_string(mode) + " of '" + element.name +
             "' is rigid and can be no dof");
}

/// Where the motion starts; at an equilibrium it is not for the scene to say.
void read_start(const YamlReader& value, const Scene& scene, SceneDof& dof) {
  const auto given = value.find("value"), rate = value.find("rate");
  for (const auto& key : {given, rate}) {
    if (key && scene.operating_point != OperatingPoint::as_written) {
      key->fail("needs operating_point: as_written; an equilibrium finds its own");
    }
  }
  if (given) dof.value = read_displacement(*given);
  if (rate) dof.rate = rate->number();
}

void read_element_dof(const YamlReader& value, const Scene& scene, SceneDof& dof) {
  for (const char* key : {"along", "euler_parameter", "rotation"}) {
    refuse(value, key, "belongs to 'node', not to 'element'");
  }
  const SceneElement& element = read_element_name(value.require("element"), scene);
  if (element.rigid()) fail_rigid(value, element, 0);
  dof.element = element.name;
  dof.mode = read_mode(value, element, 0);
  if (element.zero[static_cast<size_t>(dof.mode) - 1]) fail_rigid(value, element, dof.mode);
}

void read_node_dof(const YamlReader& value, const Scene& scene, SceneDof& dof) {
  refuse(value, "mode", "belongs to 'element', not to 'node'");
  if (scene.planar) {
    refuse(value, "euler_parameter", "a planar scene has none, write rotation: true");
  } else {
    refuse(value, "rotation", "is for planar scenes, write euler_parameter: 1, 2 or 3");
  }
  dof.node = read_node_name(value.require("node"), scene).name;
  const auto along = value.find("along");
  const auto parameter = value.find("euler_parameter");
  const auto rotation = value.find("rotation");
  if (!along == !(parameter || rotation)) {
    value.fail(std::string("a dof of a node needs either 'along' or ") +
               (scene.planar ? "'rotation: true'" : "'euler_parameter'"));
  }
  if (along) dof.direction = read_direction(*along, scene);
  if (parameter) dof.euler_parameter = std::stoi(parameter->one_of({"0", "1", "2", "3"}));
  if (rotation) dof.rotation = rotation->one_of({"true"}) == "true";
}

/// One dof for each deformation that is not rigid, of one element or of all parts of a divided one.
void add_deformations(const YamlReader& name, const std::string& place, Scene& scene) {
  for (const SceneElement* element : read_element_parts(name, scene)) {
    if (element->rigid()) fail_rigid(name, *element, 0);
    for (size_t i = 0; i < element->zero.size(); ++i) {
      if (element->zero[i]) continue;
      SceneDof dof;
      dof.place = place;
      dof.element = element->name;
      dof.mode = static_cast<int>(i) + 1;
      scene.dofs.push_back(dof);
    }
  }
}

void read_deformations(const YamlReader& value, const YamlReader& names, Scene& scene) {
  for (const char* key : {"mode", "along", "euler_parameter", "rotation", "value", "rate"}) {
    refuse(value, key, "belongs to a single dof, not to 'deformations'");
  }
  if (names.is_scalar()) return add_deformations(names, value.place(), scene);
  for (const YamlReader& name : names.items()) add_deformations(name, value.place(), scene);
}

void read_dof(const YamlReader& value, Scene& scene) {
  value.allow_only({"element", "mode", "deformations", "node", "along", "euler_parameter",
                    "rotation", "value", "rate"});
  const auto element = value.find("element"), node = value.find("node"),
             deformations = value.find("deformations");
  if (int{element.has_value()} + int{node.has_value()} + int{deformations.has_value()} != 1) {
    value.fail("a dof names either an element or a node, or the 'deformations' of elements");
  }
  if (deformations) return read_deformations(value, *deformations, scene);
  SceneDof dof;
  dof.place = value.place();
  read_start(value, scene, dof);
  if (element) {
    read_element_dof(value, scene, dof);
  } else {
    read_node_dof(value, scene, dof);
  }
  scene.dofs.push_back(dof);
}

}  // namespace

void read_dofs(const YamlReader& value, Scene& scene) {
  scene.dofs_place = value.place();
  if (value.is_scalar()) {
    if (value.text() != "auto") {
      value.fail("found '" + value.text() + "', allowed is auto, or a sequence of dofs");
    }
    scene.automatic_dofs = true;
    return;
  }
  for (const YamlReader& item : value.items()) read_dof(item, scene);
}

}  // namespace stillframe

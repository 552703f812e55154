#include "core/mechanics/scene/references.hpp"

#include <algorithm>

#include "core/errors/formatted.hpp"

namespace stillframe {

namespace {

template <class Item>
const Item* find_name(const std::string& name, const std::vector<Item>& items) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

[[noreturn]] void fail_unknown(const YamlReader& value, const std::string& what,
                               const std::vector<std::string>& names) {
  const std::string near = nearest_name(value.text(), names);
  value.fail("there is no " + what + " named '" + value.text() + "'" +
             (near.empty() ? "" : "; the nearest name is '" + near + "'"));
}

}  // namespace

const SceneNode& read_node_name(const YamlReader& value, const Scene& scene) {
  if (const SceneNode* node = find_name(value.text(), scene.nodes)) return *node;
  std::vector<std::string> names;
  for (const SceneNode& node : scene.nodes) names.push_back(node.name);
  fail_unknown(value, "node", names);
}

const SceneElement& read_element_name(const YamlReader& value, const Scene& scene) {
  const auto parts = read_element_parts(value, scene);
  if (parts.front()->name == value.text()) return *parts.front();
  value.fail("'" + value.text() + "' is divided; name one of its parts, '" + parts.front()->name +
             "' to '" + parts.back()->name + "'");
}

std::vector<const SceneElement*> read_element_parts(const YamlReader& value, const Scene& scene) {
  const std::string name = value.text();
  if (const SceneElement* element = find_name(name, scene.elements)) return {element};
  std::vector<const SceneElement*> parts;
  for (const SceneElement& element : scene.elements) {
    if (element.name.starts_with(name + "/")) parts.push_back(&element);
  }
  if (!parts.empty()) return parts;
  std::vector<std::string> names;
  for (const SceneElement& element : scene.elements) {
    names.push_back(element.name);
    // The whole of a divided beam is near as well.
    names.push_back(element.name.substr(0, element.name.find('/')));
  }
  fail_unknown(value, "element", names);
}

int read_mode(const YamlReader& map, const SceneElement& element, int otherwise) {
  const std::string has = "'" + element.name + "' has " + std::to_string(element.n_deformations) +
                          (element.n_deformations == 1 ? " deformation" : " deformations");
  if (const auto mode = map.find("mode")) {
    const std::int64_t number = mode->integer(1);
    if (number > element.n_deformations) mode->fail("found " + mode->text() + ", but " + has);
    return static_cast<int>(number);
  }
  if (otherwise == 0) {
    const bool plain = element.n_deformations == 1 || element.kind == SceneElement::Kind::hinge;
    if (!plain) map.fail("the key 'mode' is missing: " + has);
    return 1;
  }
  return otherwise;
}

Eigen::Vector3d read_vector(const YamlReader& value, const Scene& scene) {
  if (!scene.planar) return value.vector(3);
  const Eigen::VectorXd given = value.vector();
  if (given.size() < 2 || given.size() > 3) {
    value.fail("found " + std::to_string(given.size()) +
               " numbers, allowed in a planar scene are two, or three with z = 0");
  }
  if (given.size() == 3 && given(2) != 0) {
    value.fail("found z = " + shown(given(2)) + ", but the scene is planar");
  }
  return {given(0), given(1), 0};
}

double read_displacement(const YamlReader& value) {
  constexpr double largest = 1e4;
  return value.number(largest);
}

Eigen::Vector3d read_direction(const YamlReader& value, const Scene& scene) {
  if (value.is_scalar()) {
    const std::string axis =
        scene.planar ? value.one_of({"x", "y"}) : value.one_of({"x", "y", "z"});
    return Eigen::Vector3d::Unit(axis[0] - 'x');
  }
  const Eigen::Vector3d direction = read_vector(value, scene);
  if (direction.isZero(0)) value.fail("a direction cannot be zero");
  return direction.stableNormalized();
}

void refuse_slash(const YamlReader& value, const std::string& name) {
  if (name.find('/') == std::string::npos) return;
  value.fail("a '/' is reserved for the parts of divided beams, choose a name without");
}

std::string shown(double number) { return formatted("%.6g", number); }

}  // namespace stillframe

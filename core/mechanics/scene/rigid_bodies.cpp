#include "core/mechanics/scene/rigid_bodies.hpp"

#include <algorithm>

namespace stillframe {

namespace {

using Kind = SceneElement::Kind;

/// A beam that does nothing but join its nodes.
bool joins(const SceneElement& element) {
  return element.kind == Kind::rigid_beam && element.beam.mass_per_length == 0 &&
         element.beam.inertia_per_length == 0;
}

/// The nodes that must stay nodes.
std::set<std::string> anchors(const Scene& scene, std::set<std::string> nodes) {
  const auto take = [&](const auto& items) {
    for (const auto& item : items) nodes.insert(item.node);
  };
  take(scene.masses);
  take(scene.loads);
  take(scene.supports);
  take(scene.prescribed);
  take(scene.dofs);
  take(scene.inputs);
  take(scene.disturbances);
  for (const SceneElement& element : scene.elements) {
    if (element.kind == Kind::truss || joins(element)) continue;
    if (element.superelement) {
      nodes.insert(element.superelement->nodes.begin(), element.superelement->nodes.end());
    }
    nodes.insert(element.node_p);
    nodes.insert(element.node_q);
  }
  return nodes;
}

/// A node with a single rigid beam that is no anchor, and the beam; or the end.
std::vector<SceneElement>::iterator find_leaf(std::vector<SceneElement>& elements,
                                              const std::set<std::string>& anchors,
                                              std::string& leaf) {
  std::map<std::string, int> beams;
  for (const SceneElement& element : elements) {
    if (!joins(element)) continue;
    ++beams[element.node_p];
    ++beams[element.node_q];
  }
  return std::find_if(elements.begin(), elements.end(), [&](const SceneElement& element) {
    if (!joins(element)) return false;
    for (const std::string& node : {element.node_q, element.node_p}) {
      leaf = node;
      if (beams[node] == 1 && !anchors.contains(node)) return true;
    }
    return false;
  });
}

}  // namespace

MergedScene merge_rigid_bodies(const Scene& scene, const std::set<std::string>& keep) {
  MergedScene merged{scene, {}};
  if (scene.planar || scene.automatic_dofs) return merged;
  const std::set<std::string> fixed = anchors(scene, keep);
  std::map<std::string, Eigen::Vector3d> position;
  for (const SceneNode& node : scene.nodes) position[node.name] = node.position;

  auto& elements = merged.scene.elements;
  std::string leaf;
  for (auto beam = find_leaf(elements, fixed, leaf); beam != elements.end();
       beam = find_leaf(elements, fixed, leaf)) {
    const std::string body = beam->node_p == leaf ? beam->node_q : beam->node_p;
    elements.erase(beam);
    for (auto& [name, carried] : merged.carried) {
      if (carried.body == leaf) carried.body = body;
    }
    merged.carried[leaf].body = body;
  }
  for (auto& [name, carried] : merged.carried) {
    carried.arm = position[name] - position[carried.body];
  }
  for (SceneElement& element : elements) {
    const auto attach = [&](std::string& node, Eigen::Vector3d& arm) {
      const auto found = merged.carried.find(node);
      if (found == merged.carried.end()) return;
      node = found->second.body;
      arm = found->second.arm;
    };
    attach(element.node_p, element.arm_p);
    attach(element.node_q, element.arm_q);
  }
  std::erase_if(merged.scene.nodes,
                [&](const SceneNode& node) { return merged.carried.contains(node.name); });
  return merged;
}

}  // namespace stillframe

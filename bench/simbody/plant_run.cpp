#include "bench/simbody/plant_run.hpp"

#include <chrono>
#include <stdexcept>

#include "plant_sim/floor/sources.hpp"
#include "plant_sim/plant.hpp"

namespace stillframe::simbody {

namespace {

const Eigen::Vector3d& position_of(const Scene& scene, const std::string& name) {
  for (const SceneNode& node : scene.nodes) {
    if (node.name == name) return node.position;
  }
  throw std::runtime_error("no node " + name);
}

MassProperties mass_at(const Scene& scene, const std::string& node) {
  for (const SceneMass& mass : scene.masses) {
    if (mass.node == node) return {mass.mass, mass.inertia};
  }
  throw std::runtime_error("no mass at " + node);
}

}  // namespace

BodyOnSprings body_on_springs(const Scene& scene) {
  BodyOnSprings result;
  const std::string& body = scene.masses.front().node;
  result.body = mass_at(scene, body);
  result.centre = position_of(scene, body);
  result.sample_time = 1 / scene.controller->sample_rate_hz;
  for (const SceneSignal& input : scene.inputs) {
    for (const SceneElement& element : scene.elements) {
      if (element.kind != SceneElement::Kind::truss || element.node_p != input.node) continue;
      result.springs.push_back({position_of(scene, element.node_q), position_of(scene, input.node),
                                input.direction, element.stiffness(0, 0)});
    }
  }
  for (const SceneSignal& output : scene.outputs) {
    result.outputs.push_back({0, position_of(scene, output.node), output.direction});
  }
  return result;
}

LinkChain link_chain(const Scene& scene) {
  LinkChain result;
  result.gravity = scene.gravity;
  result.sample_time = 1 / scene.controller->sample_rate_hz;
  std::vector<std::string> ends;
  for (const SceneElement& hinge : scene.elements) {
    if (hinge.kind != SceneElement::Kind::hinge) continue;
    for (const SceneElement& link : scene.elements) {
      if (link.kind != SceneElement::Kind::rigid_beam || link.node_p != hinge.node_q) continue;
      result.links.push_back({mass_at(scene, link.node_q), position_of(scene, hinge.node_q),
                              hinge.axis.normalized(), position_of(scene, link.node_q)});
      ends.push_back(link.node_q);
    }
  }
  for (const SceneSignal& output : scene.outputs) {
    size_t body = 0;
    while (ends.at(body) != output.node) ++body;
    result.outputs.push_back({body, position_of(scene, output.node), output.direction});
  }
  return result;
}

Run plant_run(Scene scene, const Eigen::MatrixXd& floor, double tolerance) {
  // Simbody's library holds an older SUNDIALS under the same names, which would be taken for ours:
  // in this program only the methods that are our own can run.
  scene.simulation.method = scene.gravity.isZero(0) ? PlantMethod::exponential : PlantMethod::nodal;
  scene.simulation.relative_tolerance = tolerance;
  Plant plant(scene, std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::inputs, floor));
  const Eigen::VectorXd command =
      Eigen::VectorXd::Zero(static_cast<Index>(scene.controller->legs.size()));
  const auto n_outputs = static_cast<Index>(scene.outputs.size());
  Run result;
  result.accelerations.resize(n_outputs, floor.cols());
  const auto begin = std::chrono::steady_clock::now();
  for (Index k = 0; k < floor.cols(); ++k) {
    if (const std::string reason = plant.advance(command); !reason.empty()) {
      throw std::runtime_error(reason);
    }
    result.accelerations.col(k) = plant.read().frame_acceleration.head(n_outputs);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace stillframe::simbody

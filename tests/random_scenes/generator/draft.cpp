#include "tests/random_scenes/generator/draft.hpp"

#include <cstdio>

namespace stillframe::random_scenes {

std::string Draft::number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string Draft::vector(const Eigen::Vector3d& v) const {
  return "[" + number(v.x()) + ", " + number(v.y()) + (planar ? "" : ", " + number(v.z())) + "]";
}

void Draft::node(const std::string& name, const Eigen::Vector3d& at) {
  nodes.push_back(name + ": {position: " + vector(at) + "}");
}

std::string Draft::mount(const Body& body, const std::string& name, const Eigen::Vector3d& p) {
  if (!body.turns || (p - body.at).norm() < 1e-3 * body.size) return body.node;
  node(name, p);
  elements.push_back("arm_" + name + ": {type: rigid_beam, nodes: [" + body.node + ", " + name +
                     "]}");
  points.push_back(name);
  turning.push_back(name);
  return name;
}

std::string Draft::text() const {
  std::string out = "title: " + title + "\n";
  if (planar) out += "planar: true\n";
  if (gravity)
    out += "gravity: " +
           vector(9.81 * (planar ? -Eigen::Vector3d::UnitY() : -Eigen::Vector3d::UnitZ())) + "\n";
  const auto block = [&out](const char* key, const std::vector<std::string>& lines, bool map) {
    if (lines.empty()) return;
    out += std::string(key) + ":\n";
    for (const std::string& line : lines) out += (map ? "  " : "  - ") + line + "\n";
  };
  block("nodes", nodes, true);
  block("masses", masses, false);
  block("elements", elements, true);
  block("supports", supports, false);
  block("prescribed", prescribed, false);
  if (dofs.empty()) {
    out += "dofs: auto\n";
  } else {
    block("dofs", dofs, false);
  }
  block("loads", loads, false);
  block("inputs", inputs, false);
  block("outputs", outputs, false);
  block("monitors", monitors, false);
  block("compare", comparisons, true);
  block("disturbances", disturbances, false);
  for (const std::string& line : blocks) out += line + "\n";
  return out;
}

std::string random_scene(std::uint64_t seed) {
  Draft draft(seed);
  Draws& draws = draft.draws;
  draft.title = "Random scene " + std::to_string(seed);
  draft.planar = draws.chance(0.25);
  draft.gravity = draws.chance(0.4);
  if (draws.chance(0.1)) {
    add_turning_table(draft);
  } else {
    add_frame(draft);
    add_legs(draft);
    if (draws.chance(0.25)) add_mast(draft);
    if (draws.chance(0.2)) add_pendulum(draft);
    if (draws.chance(0.2)) add_stage(draft);
    if (draws.chance(0.1)) add_rotor(draft);
    if (draws.chance(0.3)) add_loads(draft);
  }
  add_dofs(draft);
  add_signals(draft);
  add_controller(draft);
  add_instruments(draft);
  add_floor(draft);
  add_disturbances(draft);
  if (draws.chance(0.15)) {  // the last draw: the scenes without are those of before
    std::string ratios = Draft::number(draws.scale(1e-3, 0.1));
    if (draws.chance(0.3)) {
      const auto point = [&draft](double part, const std::string& ratio) {
        return "[" + Draft::number(part * draft.frequency_hz) + ", " + ratio + "]";
      };
      ratios = "[" + point(0.5, "0") + ", " + point(2, ratios) + ", " + point(30, "0.01") + "]";
    }
    draft.blocks.push_back("modal_damping: " + ratios);
  }
  return draft.text();
}

}  // namespace stillframe::random_scenes

#include <algorithm>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

namespace {

std::string axis_of(Draws& draws, bool planar) {
  static const std::vector<std::string> axes = {"x", "y", "z"};
  return axes[static_cast<size_t>(draws.below(planar ? 2 : 3))];
}

/// Accelerations of the floor below legs, along them or along an axis; of the frame above.
void add_loop_signals(Draft& draft) {
  Draws& draws = draft.draws;
  const size_t n = std::min<size_t>(draft.legs.size(), static_cast<size_t>(draws.whole(1, 6)));
  for (size_t i = 0; i < n; ++i) {
    const Strut& leg = draft.legs[i];
    const std::string name = std::to_string(i + 1);
    const std::string along =
        draws.chance(0.8) ? draft.vector(leg.along) : axis_of(draws, draft.planar);
    draft.inputs.push_back("{name: floor_" + name + ", acceleration: " + leg.floor +
                           ", along: " + along + "}");
    draft.outputs.push_back("{name: frame_" + name + ", acceleration: " + leg.mount +
                            ", along: " + along + "}");
  }
  for (const char* axis : {"x", "y", "z"}) {
    const std::string name = axis;
    if (draft.planar && name == "z") continue;
    draft.monitors.push_back("{name: below_" + name + ", acceleration: " + draft.legs[0].floor +
                             ", along: " + name + "}");
    draft.monitors.push_back("{name: above_" + name + ", acceleration: " + draft.points.back() +
                             ", along: " + name + "}");
    if (draws.chance(0.7))
      draft.comparisons.push_back(name + ": {floor: below_" + name + ", frame: above_" + name +
                                  "}");
  }
}

std::string along(Draft& draft) {
  return ", along: " + draft.vector(draft.draws.direction(draft.planar)) + "}";
}

/// Signals that go round with the table: along axes fixed in space nothing of it is stationary.
void add_table_signals(Draft& draft) {
  draft.inputs.push_back("{name: drive, stress: spring_1}");
  draft.inputs.push_back("{name: spin_up, deformation_acceleration: axle}");
  draft.outputs.push_back("{name: force, stress: spring_1}");
  draft.outputs.push_back("{name: longer, deformation: spring_2}");
  draft.outputs.push_back("{name: longer_fast, deformation_rate: spring_2}");
  draft.outputs.push_back("{name: axle_torque, stress: axle}");
}

/// One of each kind that a linear model may be asked for.
void add_all_kinds(Draft& draft) {
  Draws& draws = draft.draws;
  const auto node = [&] { return draws.one_of(draft.points); };
  draft.inputs.push_back("{name: push, force: " + node() + along(draft));
  if (!draft.turning.empty()) {
    draft.inputs.push_back("{name: twist, torque: " + draws.one_of(draft.turning) +
                           (draft.planar ? "}" : along(draft)));
    const std::string about = draft.planar ? "}" : along(draft);
    const std::string turned = draws.one_of(draft.turning);
    draft.outputs.push_back("{name: turns, rotation: " + turned + about);
    draft.outputs.push_back("{name: turns_fast, angular_velocity: " + turned + about);
    draft.outputs.push_back("{name: turns_faster, angular_acceleration: " + turned + about);
  }
  draft.outputs.push_back("{name: moves, position: " + node() + along(draft));
  draft.outputs.push_back("{name: moves_fast, velocity: " + node() + along(draft));
  draft.outputs.push_back("{name: moves_faster, acceleration: " + node() + along(draft));
  const Strut& leg = draws.one_of(draft.legs);
  draft.inputs.push_back("{name: drive, stress: " + leg.name + "}");
  const char* kind = draws.one_of<const char*>({"position", "velocity", "acceleration"});
  draft.inputs.push_back("{name: shake, " + std::string(kind) + ": " + leg.floor + along(draft));
  draft.outputs.push_back("{name: force, stress: " + leg.name + "}");
  draft.outputs.push_back("{name: longer, deformation: " + leg.name + "}");
  draft.outputs.push_back("{name: footing, reaction: " + leg.floor + along(draft));
}

}  // namespace

void add_signals(Draft& draft) {
  if (!draft.shakers.empty()) {
    std::string names;
    for (const std::string& name : draft.shakers) names += (names.empty() ? "" : ", ") + name;
    draft.prescribed.push_back("{nodes: [" + names +
                               "], move: " + (draft.planar ? "[x, y]}" : "[x, y, z]}"));
  }
  if (draft.legs.empty()) {
    add_table_signals(draft);
  } else if (draft.draws.chance(0.8)) {
    add_loop_signals(draft);
  } else {
    add_all_kinds(draft);
  }
}

}  // namespace stillframe::random_scenes

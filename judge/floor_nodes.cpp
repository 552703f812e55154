#include "judge/floor_nodes.hpp"

#include <variant>

namespace stillframe::judge {

namespace {

/// What a floor moves.
struct Moved {
  bool axes = false, inputs = false;
};

void add(const floor::FloorSpec& spec, Moved& moved);

void add(const floor::RecordingSpec&, Moved& moved) { moved.axes = true; }
void add(const MultisinePlan&, Moved& moved) { moved.inputs = true; }
void add(const floor::WhiteSpec&, Moved& moved) { moved.inputs = true; }
void add(const floor::StillSpec&, Moved&) {}

void add(const floor::NoiseSpec& noise, Moved& moved) {
  (noise.axes.empty() ? moved.inputs : moved.axes) = true;
}

void add(const floor::CourseSpec& course, Moved& moved) {
  (course.target.axis ? moved.axes : moved.inputs) = true;
}

void add(const floor::SumSpec& sum, Moved& moved) {
  for (const floor::FloorSpec& part : sum.parts) add(part, moved);
}

void add(const floor::FloorSpec& spec, Moved& moved) {
  std::visit([&](const auto& kind) { add(kind, moved); }, spec.kind);
}

}  // namespace

FloorNodes floor_nodes(const floor::FloorSpec& spec) {
  Moved moved;
  add(spec, moved);
  if (!moved.inputs) return FloorNodes::follow;
  return moved.axes ? FloorNodes::unknown : FloorNodes::rest;
}

}  // namespace stillframe::judge

#include <numbers>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

void add_loads(Draft& draft) {
  Draws& draws = draft.draws;
  const double omega = 2 * std::numbers::pi * draft.frequency_hz;
  for (int i = draws.whole(1, 2); i > 0; --i) {
    const std::string node = draws.one_of(draft.points);
    // What moves the frame by up to a hundredth of its size; on what it carries, a tenth of that.
    const double force = 0.01 * draft.frame.size * draft.frame.mass * omega * omega *
                         (node == "frame" ? 1 : 0.02) * draws.scale(0.01, 1);
    std::string text =
        "{node: " + node + ", force: " + draft.vector(force * draws.direction(draft.planar));
    const bool turns =
        std::find(draft.turning.begin(), draft.turning.end(), node) != draft.turning.end();
    if (turns && draws.chance(0.3)) {
      const double torque = 0.1 * force * draft.frame.size;
      text += ", torque: " + (draft.planar ? Draft::number(torque)
                                           : draft.vector(torque * draws.direction(false)));
    }
    if (turns && draws.chance(0.3)) text += ", follows: true";
    draft.loads.push_back(text + "}");
  }
}

void add_dofs(Draft& draft) {
  // Coordinates that the program chooses may be those of a wheel, which are not stationary.
  if (!draft.has_rotor && draft.draws.chance(0.4)) draft.dofs.clear();
}

}  // namespace stillframe::random_scenes

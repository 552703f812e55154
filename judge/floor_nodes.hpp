#pragma once

#include <cstdint>

#include "plant_sim/floor/floor_block.hpp"

namespace stillframe::judge {

/// What the nodes of a floor do in directions that no input of their scene measures.
enum class FloorNodes : std::uint8_t {
  follow,   ///< they move with the floor: one that moves as a body, along its axes
  rest,     ///< none of them moves: the floor moves inputs, each on its own
  unknown,  ///< both at once, and no input tells how much of either
};

/// By the floor block of a run. A floor that moves nothing is one that would move as a body.
FloorNodes floor_nodes(const floor::FloorSpec& spec);

}  // namespace stillframe::judge

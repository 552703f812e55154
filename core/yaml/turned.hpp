#pragma once

#include "core/yaml/tree.hpp"

namespace stillframe {

/// Cosine and sine of an angle, exact to rounding and without a remainder at multiples of 30
/// degrees: symmetric frames stay symmetric.
struct Turn {
  double cos = 1, sin = 0;
};
Turn turn_of_degrees(double degrees);
/// `part` of `parts` equal parts of a turn.
Turn turn_of_part(int part, int parts);

/// Turns, about an axis through the origin, what stands in a value and below it: positions,
/// directions, forces and torques in the axes of the scene, and inertias. Words and numbers that
/// are none of these stay. axis: 'x', 'y' or 'z'.
void turn_all(YamlTree& tree, char axis, const Turn& turn);

}  // namespace stillframe

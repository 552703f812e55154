#pragma once

#include "core/systems/state_space_model.hpp"

namespace stillframe::test {

/// The same system with direct inputs only: velocity and position of every prescribed motion that
/// enters by its acceleration, and the position of one that enters by its velocity, join the state
/// (x, then for each such input in order its velocity, its position), so that A, B, C, D alone are
/// the whole proper system. States that neither B nor D would use are left out. Set-up.
/// Source: deck, section 10, Note 2; the velocity case likewise.
/// Errors: std::invalid_argument for shapes that do not match, and for an input whose derivatives
/// would be needed (a motion given by its position whose velocity or acceleration acts).
StateSpace augmented(const StateSpace& system);

}  // namespace stillframe::test

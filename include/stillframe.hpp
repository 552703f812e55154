#pragma once

// What most programs need, in the order of the work; docs/architecture.md says where the rest is.
// IWYU pragma: begin_exports
#include "controller/law.hpp"                      // the law as it runs: Law
#include "core/control/design/control_loop.hpp"    // gains of a scene: make_control_loop
#include "core/control/loop_settings.hpp"          // the sampled loop: close_loop, spectral_radius
#include "core/errors/input_error.hpp"             // InputError, Refusal
#include "core/mechanics/equilibrium.hpp"          // solve_equilibrium
#include "core/mechanics/frequency_response.hpp"   // transfer_function, singular_values
#include "core/mechanics/modes.hpp"                // natural frequencies, damping, shapes
#include "core/mechanics/operating_point.hpp"      // nominal_motion
#include "core/mechanics/scene/scene_builder.hpp"  // a scene in C++: SceneBuilder
#include "core/mechanics/scene/scene_reader.hpp"   // a scene from a file or a text
#include "core/mechanics/state_space.hpp"          // A, B, C, D
#include "plant_sim/command_queue.hpp"             // commands on their way
#include "plant_sim/floor/floor_block.hpp"         // how the floor moves
#include "plant_sim/plant.hpp"                     // the nonlinear frame on its floor
// IWYU pragma: end_exports

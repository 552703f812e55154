#pragma once

#include <algorithm>
#include <iterator>

#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// What a signal belongs to, and so which keys of a scene go with it.
enum class SignalOf { translation, rotation, deformation };

/// All that a quantity is known by.
struct QuantityTraits {
  const char* word;  ///< its key in scenes
  Quantity quantity;
  SignalOf of;
  const char* unit;  ///< of deformations those of a length
  int derivative;    ///< of a motion 0, 1 or 2: how often it is differentiated; -1: no motion
  bool as_input, as_output;
};

/// In the order in which messages name them.
inline constexpr QuantityTraits known_quantities[] = {
    {"position", Quantity::position, SignalOf::translation, "m", 0, true, true},
    {"velocity", Quantity::velocity, SignalOf::translation, "m/s", 1, true, true},
    {"acceleration", Quantity::acceleration, SignalOf::translation, "m/s^2", 2, true, true},
    {"force", Quantity::force, SignalOf::translation, "N", -1, true, false},
    {"reaction", Quantity::reaction, SignalOf::translation, "N", -1, false, true},
    {"rotation", Quantity::rotation, SignalOf::rotation, "rad", 0, true, true},
    {"angular_velocity", Quantity::angular_velocity, SignalOf::rotation, "rad/s", 1, true, true},
    {"angular_acceleration", Quantity::angular_acceleration, SignalOf::rotation, "rad/s^2", 2, true,
     true},
    {"torque", Quantity::torque, SignalOf::rotation, "N m", -1, true, false},
    {"reaction_moment", Quantity::reaction_moment, SignalOf::rotation, "N m", -1, false, true},
    {"stress", Quantity::stress, SignalOf::deformation, "N", -1, true, true},
    {"deformation", Quantity::deformation, SignalOf::deformation, "m", 0, true, true},
    {"deformation_rate", Quantity::deformation_rate, SignalOf::deformation, "m/s", 1, true, true},
    {"deformation_acceleration", Quantity::deformation_acceleration, SignalOf::deformation, "m/s^2",
     2, true, true},
};

inline const QuantityTraits& traits_of(Quantity quantity) {
  return *std::find_if(std::begin(known_quantities), std::end(known_quantities),
                       [quantity](const QuantityTraits& of) { return of.quantity == quantity; });
}

/// Whether it is a motion, which as an input is prescribed, or else a force or a stress.
inline bool is_motion(Quantity quantity) { return traits_of(quantity).derivative >= 0; }

}  // namespace stillframe

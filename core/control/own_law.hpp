#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/control/discrete_law.hpp"

namespace stillframe {

/// A sampled linear law as its designer has it, inputs y and outputs u by name:
///   u[k] = C x[k] + D y[k],   x[k+1] = A x[k] + B y[k].
/// n states (none: a matrix of gains), y and u of the same measurement, u the force that is
/// commanded. A: n x n, B: n x inputs, C: outputs x n, D: outputs x inputs.
struct NamedLaw {
  std::vector<std::string> inputs, outputs;
  Eigen::MatrixXd A, B, C, D;
};

/// Names of what a law may hear and say, before those of legs and floor accelerations.
inline constexpr const char *sigma_prefix = "sigma:", *applied_prefix = "applied:",
                            *strain_prefix = "strain_force:", *floor_prefix = "floor:",
                            *force_prefix = "force:";

/// Whether a name is one of a floor acceleration.
bool hears_floor(const NamedLaw& law);

/// The same, deaf to the floor.
NamedLaw without_floor(const NamedLaw& law);

/// A named law in the order of the messages, for m legs and p floor accelerations:
///   "sigma:LEG"         N, the force sensor of a leg
///   "applied:LEG"       N, the force that its actuator really applied, as it is reported
///   "strain_force:LEG"  N, sigma less applied
///   "floor:NAME"        m/s^2, an acceleration of the floor
///   "force:LEG"         N, out; one of each leg
/// What is not named is not heard. What it does with the floor becomes the feed-forward, in states
/// of its own: without those that the floor does not move or that move no force. That is the same
/// law, as it is linear; and if a sensor of the floor breaks its share can be faded out alone.
/// Set-up. Errors: InputError on sizes, on names that are unknown, doubled or missing, on entries
/// that are not finite, and if the states behind the floor do not decay by themselves, as no
/// feedback would bring them to rest.
DiscreteLaw own_law(const NamedLaw& law, const std::vector<std::string>& legs,
                    const std::vector<std::string>& floor);

/// The law as a NamedLaw, of everything that it hears: own_law gives it back. The memory of a
/// filter on the applied force becomes states of it.
NamedLaw named(const DiscreteLaw& law, const std::vector<std::string>& legs,
               const std::vector<std::string>& floor);

}  // namespace stillframe

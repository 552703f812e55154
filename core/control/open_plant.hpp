#pragma once

#include "core/systems/linear_system.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// The sampled plant as a law finds it, for whoever designs one: all that lies between a command
/// and the next measurement, with the commands and reports that are under way as states.
///   inputs   w[k] (p, m/s^2, held from sample k to the next), u[k] (m, N, commanded from sample k)
///   outputs  y[k+1] (as SampledPlant has it, the mean up to the next sample, m/s^2),
///            sigma[k] (m, N), applied[k] (m, N, as it is reported), w[k-1] (p, m/s^2):
///            the measurement k that u[k] answers.
/// No u[k] is in measurement k: D has zeros there. Closed by a law, it is close_loop of the two.
/// Set-up.
LinearSystem open_plant(const SampledPlant& plant);

}  // namespace stillframe

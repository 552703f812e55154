#pragma once

#include <string>
#include <vector>

#include "controller/gains.hpp"

namespace stillframe::controller {

/// A closed loop must have a spectral radius below this to be called stable.
/// Without a leak the pure integrator cancels the static spring and leaves poles at exactly 1
/// (THEORY section 4, fact 2). After balancing, those come out within 1e-13 of 1; the bound leaves
/// four decades for larger models. It refuses nothing of use: at 10 kHz it stands for a decay over
/// 100 000 s, and a leak of as little as 1 mHz decays at 1e-7 a sample.
inline constexpr double largest_stable_radius = 1.0 - 1e-9;

/// Spectral radius of plant (zero-order hold, exact), law, delay, leak and roll-off as one sampled
/// system, saturation left out.
/// Source: THEORY section 4, fact 3. Set-up. Errors: std::invalid_argument on shapes, Refusal as
/// law_from_gains.
double closed_loop_radius(const Gains& gains);

/// A change to a gains file that gives a stable loop.
struct Remedy {
  std::string change;  ///< as it would be written in the file, "leak_hz: 0.05"
  double radius = 0;   ///< spectral radius with the change
};

/// The changes of one setting that really give a stable loop, or of two settings if no single one
/// does; each is tried numerically. Set-up.
std::vector<Remedy> find_remedies(const Gains& gains);

/// The spectral radius of gains that may be run. Set-up. Errors: Refusal if the loop is not stable,
/// saying the radius, the reason and what mends it.
double require_stable(const Gains& gains);

}  // namespace stillframe::controller

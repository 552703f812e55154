#pragma once

#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/rig/probe.hpp"
#include "controller/rig/scaled_io.hpp"

namespace stillframe::controller {

/// What one signal of a leg turned out to be.
struct SignalFinding {
  Eigen::Index cable = -1;  ///< the leg whose cable it is on; -1: it did not answer
  double gain = 1;  ///< it is so many times as large as the rig file makes it; below 0: sign
};

/// What the probe of a leg says.
struct LegFinding {
  std::string leg;
  SignalFinding sigma, applied, force;
  double sigma_noise = 0;          ///< N, of a line's mean at rest
  double sigma_mean = 0;           ///< N, at rest
  double delay_samples = 0;        ///< by which the leg answers later than the gains say
  double doubt = 0;                ///< 1, standard deviation of the gain of sigma
  std::vector<std::string> wrong;  ///< in words, one each; empty: as the rig file and the gains say
};

struct Wiring {
  std::vector<LegFinding> legs;
  Channels channels;      ///< the rig file's, with what was found put right
  bool sound = true;      ///< nothing is wrong
  bool connected = true;  ///< the channels put right all that is wrong but for delays
  bool mended = true;     ///< the channels put right all that is wrong
};

/// Frequencies at which the legs answer with the forces of their own actuators: between 0.2 and
/// 0.42 of the rate, where the frame's inertia holds it still.
std::vector<int> probe_lines(std::int64_t n_window);

/// Compares what a rig answered with what the plant of the gains would:
///   r_s = sigma / (G_sigma u), r_a = applied / (G_applied u) over the lines, each a gain, a sign
///   and a
/// delay. Read-back, amplifier and sensor are told apart by what they share: an amplifier is in
/// both r_s and r_a, a sensor in r_s, a read-back in r_a alone; where the sizes of both are off and
/// not alike, the read-back is believed. tolerance: of a gain, 1. Set-up. Errors: as
/// sample_and_hold.
Wiring wiring_of(const Probe& probe, const ProbeSettings& settings, const Gains& gains,
                 const Channels& channels, double tolerance = 0.01);

}  // namespace stillframe::controller

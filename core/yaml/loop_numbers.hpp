#pragma once

namespace stillframe {

// Ranges of what a controller block and a gains file say of a loop. They are far beyond any loop of
// use, and small enough that no product of them leaves the doubles and no judgement takes minutes.

inline constexpr double lowest_rate_hz = 1, highest_rate_hz = 1e6;
/// Of every corner, target and mode.
inline constexpr double highest_hz = 1e6;
/// Samples that commands and reports may be under way. Each is a state of the loop for each leg,
/// and the time of a judgement is the cube of the states: 100 of them on six legs took 25 s.
inline constexpr int longest_delay_samples = 20;
/// A lead makes up for an actuator as well: 1 / (2 pi T_s) over its corner.
inline constexpr double longest_lead_samples = 1e4;
inline constexpr double largest_force_n = 1e9;
/// Of a feed-forward, for each channel of the floor: its step would take longer than all else.
inline constexpr int most_taps = 64;
/// Of gains, and of the matrices of a plant in SI units: a mode at highest_hz has 4e13.
inline constexpr double largest_entry = 1e18;

}  // namespace stillframe

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mechanics/scene/acceptance.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

/// Largest shares of periods where a scene asks for none. A limiter has for a Gaussian force the
/// gain 1 - p, where p is the share of time that it limits (J. J. Bussgang, MIT RLE report 216,
/// 1952): 1 % takes 0.09 dB off the loop, which is what a prediction is met within. In a period
/// without a sound measurement the controller holds its last force: 1 % of those makes the mean
/// delay longer by a hundredth of a sample. Samples that the log lacks are a damaged record: none.
inline constexpr double default_limited_share = 0.01, default_unanswered_share = 0.01,
                        default_discarded_share = 0.01, default_log_loss_share = 0;

/// dB, of how far beyond its band a tenth of the values of an identified response may lie where a
/// scene says nothing: a third of the force is missing or too much then, over more than a
/// resonance. A linear model of a sound loop is known better, but a floor is no test signal: what
/// it moves along and no input measures, forces and distortion are in the log too (decision 21).
inline constexpr double default_broad_prediction_db = 3;

/// A share of what the model makes of forces on the frame: so much more or less they may have done,
/// 10^(3/20) - 1, where a loop passes that is broadly the predicted one.
inline constexpr double doubt_of_forces = 0.413;

/// Averages are of at least so many periods of the lowest frequency that they hold, 1 Hz where what
/// is asked begins higher, ...
inline constexpr double least_periods = 10;
/// ... and the floor is said to move in a range if its rms there is this share of that from 1 to 80
/// Hz at least: below it a window's leakage, and the sensors, would be compared.
inline constexpr double least_floor_share = 1e-3;

/// m/s^2 rms. A frame that moves less than the first rests but for rounding: solvers leave 1e-13 of
/// a weight. Less than the second no accelerometer tells from rest: the quietest places on Earth
/// have it in a band of 80 Hz (the low noise model of Peterson, 1e-10 m/s^2/sqrt(Hz)).
inline constexpr double rounding_acceleration = 1e-12, least_acceleration = 1e-9;

/// What is asked of an axis, with no levels yet: what the scene names, or else that the active
/// frame moves no more than the passive one in the range that is judged (Verdict::judged), and no
/// more than the floor from isolates_above_hz on.
std::vector<AskedMotion> asked_of(const SceneAcceptance& accept, const std::string& axis,
                                  const Verdict& verdict);

/// Everything that is asked of a run, in the order in which it is to be read: the records, what
/// limited the loop, how the frame moved, and how the loop meets its prediction (`prediction`).
/// An axis that is not asked for by name is judged where it moves beside the others
/// (moves_too_little). verdict: all but its judgement. NaN passes nothing.
Judgement judge(const Verdict& verdict, const SceneAcceptance& accept,
                std::vector<Check> prediction);

}  // namespace stillframe::report

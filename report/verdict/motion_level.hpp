#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "report/spectra/spectra.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

/// The rms that people compare is of these frequencies, Hz.
inline constexpr double lowest_level_hz = 1, highest_level_hz = 80;

/// What the motion of a frame is judged over where nobody says otherwise: these frequencies, and
/// down to half the slowest mode or target and up to where an axis of its scene ends. axis:
/// frequency_range() of the scene, which begins at a tenth of the slowest, rounded down: five times
/// that is half of it or a little less. (A frame does nothing below its modes and its target but
/// follow the floor.)
FrequencyRange judged_range(const FrequencyRange& axis);

/// What an acceleration comes to. density: its PSD, (m/s^2)^2 / Hz; band_velocity:
/// third_octave_velocity() of it, m/s rms; peak: largest sample, m/s^2. Errors: as vibration_class.
MotionLevel motion_level(const Psd& density, const Eigen::VectorXd& band_velocity, double peak);

/// Where all samples of an active run say the opposite of what its range does, in words: more than
/// the passive frame by rms or peak, and no more than it in every range that is asked of.
std::string worse_over_all(const AxisLevels& axis);

/// A share of what the passive frame moves along its largest axis. Whoever moves less along another
/// adds less than 1e-6 to the power of the whole, whatever its ratio to next to nothing; and motion
/// of the second order, as of legs that turn while the frame moves sideways, is of this size.
inline constexpr double least_axis_share = 1e-3;

/// Whether neither floor nor passive nor active frame moves along an axis by least_axis_share of
/// what floor and passive frame (the floor alone where there is no passive run) do along the
/// largest: what an active frame moves excuses nothing. axes: all that are compared, of which the
/// levels within the range of `motion` count; rad/s^2 counts as m/s^2 at a metre.
bool moves_too_little(const std::vector<AxisLevels>& axes, const AskedMotion& motion);

/// How strict a class is: -1 above VC-A (or no class), 0 for VC-A, up to 6 for VC-G.
int class_rank(const std::string& vibration_class);

/// The axes in which the active frame meets a looser class than the floor below it, in words.
std::string worse_by_class(const std::vector<AxisLevels>& axes);

}  // namespace stillframe::report

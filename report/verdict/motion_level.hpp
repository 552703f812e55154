#pragma once

#include <Eigen/Core>
#include <string>

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

/// How strict a class is: -1 above VC-A (or no class), 0 for VC-A, up to 6 for VC-G.
int class_rank(const std::string& vibration_class);

/// The axes in which the active frame meets a looser class than the floor below it, in words.
std::string worse_by_class(const std::vector<AxisLevels>& axes);

}  // namespace stillframe::report

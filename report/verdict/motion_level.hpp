#pragma once

#include <Eigen/Core>
#include <string>

#include "report/spectra/spectra.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

/// The rms that people compare is of these frequencies, Hz.
inline constexpr double lowest_level_hz = 1, highest_level_hz = 80;

/// What an acceleration comes to. density: its PSD, (m/s^2)^2 / Hz; band_velocity:
/// third_octave_velocity() of it, m/s rms; peak: largest sample, m/s^2. Errors: as vibration_class.
MotionLevel motion_level(const Psd& density, const Eigen::VectorXd& band_velocity, double peak);

/// How strict a class is: -1 above VC-A (or no class), 0 for VC-A, up to 6 for VC-G.
int class_rank(const std::string& vibration_class);

/// The axes in which the active frame meets a looser class than the floor below it, in words.
std::string worse_by_class(const std::vector<AxisLevels>& axes);

}  // namespace stillframe::report

#include "report/verdict/motion_level.hpp"

#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::report {

MotionLevel motion_level(const Psd& density, const Eigen::VectorXd& band_velocity, double peak) {
  Eigen::Index band = 0;
  for (Eigen::Index i = 1; i < band_velocity.size(); ++i) {
    if (band_velocity(i) > band_velocity(band)) band = i;  // never so for one not observed
  }
  const double largest = band_velocity(band);
  return {.rms_acceleration = band_rms(density, lowest_level_hz, highest_level_hz),
          .peak_acceleration = peak,
          .largest_band_velocity = largest,
          .largest_band_hz = third_octave_bands()[static_cast<std::size_t>(band)].nominal_hz,
          .vibration_class = vibration_class(band_velocity)};
}

int class_rank(const std::string& vibration_class) {
  const auto& criteria = vibration_criteria();
  for (std::size_t i = 0; i < criteria.size(); ++i) {
    if (criteria[i].name == vibration_class) return static_cast<int>(i);
  }
  return -1;
}

std::string worse_by_class(const std::vector<AxisLevels>& axes) {
  std::string text;
  for (const AxisLevels& axis : axes) {
    if (!axis.active || !axis.floor) continue;
    const std::string &frame = axis.active->vibration_class, &floor = axis.floor->vibration_class;
    if (frame.empty() || floor.empty() || class_rank(frame) >= class_rank(floor)) {
      continue;
    }
    text +=
        (text.empty() ? "" : ", ") + axis.axis + " (" + frame + " for the floor's " + floor + ")";
  }
  return text;
}

}  // namespace stillframe::report

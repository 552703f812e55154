#include "report/verdict/motion_level.hpp"

#include <algorithm>
#include <optional>

#include "core/errors/formatted.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::report {

namespace {

/// Of any axis. A level within the range is no more than that of all of it.
double largest(const std::vector<AxisLevels>& axes, const AxisAcceptance& range,
               std::optional<double> AskedMotion::*level) {
  double largest = 0;
  for (const AxisLevels& axis : axes) {
    for (const AskedMotion& motion : axis.asked) {
      const bool within =
          motion.asked.from_hz >= range.from_hz && motion.asked.to_hz <= range.to_hz;
      if (within && motion.*level && *(motion.*level) > largest) largest = *(motion.*level);
    }
  }
  return largest;
}

}  // namespace

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

FrequencyRange judged_range(const FrequencyRange& axis) {
  return {std::min(lowest_level_hz, 5 * axis.lowest_hz),
          std::max(highest_level_hz, axis.highest_hz)};
}

std::string worse_over_all(const AxisLevels& axis) {
  if (!axis.active || !axis.passive) return {};
  const auto times = [&](double MotionLevel::*value) {
    return (*axis.active).*value / ((*axis.passive).*value);
  };
  const double rms = times(&MotionLevel::whole_rms), peak = times(&MotionLevel::peak_acceleration);
  if (!(rms > 1) && !(peak > 1)) return {};
  const AskedMotion* calm = nullptr;
  for (const AskedMotion& motion : axis.asked) {
    if (!motion.asked.rms_of_passive || !motion.active || !motion.passive) continue;
    if (!(*motion.active <= *motion.passive)) return {};  // a check says so
    calm = &motion;
  }
  if (calm == nullptr) return {};
  return "Axis " + axis.axis +
         formatted(
             ": over all samples the active frame moves %.3g times as much as the passive one by "
             "rms and %.3g times by peak, ",
             rms, peak) +
         formatted("beside %.3g from %.4g to %.4g Hz, the range that is judged.",
                   *calm->active / *calm->passive, calm->asked.from_hz, calm->asked.to_hz);
}

bool moves_too_little(const std::vector<AxisLevels>& axes, const AskedMotion& motion) {
  const double floor = least_axis_share * largest(axes, motion.asked, &AskedMotion::floor),
               passive = least_axis_share * largest(axes, motion.asked, &AskedMotion::passive);
  // What is no number is not said to be little.
  const auto little = [](const std::optional<double>& level, double least) {
    return !level || *level <= 0 || *level < least;
  };
  return little(motion.floor, floor) && little(motion.passive, passive) && motion.active &&
         *motion.active < (motion.passive ? passive : floor);
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

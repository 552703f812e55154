#include "report/spectra/vibration_criteria.hpp"

#include <cmath>
#include <stdexcept>

#include "core/numerics/infinity.hpp"
#include "report/spectra/spectra.hpp"

namespace stillframe::report {

namespace {

/// The exact centres of the bands of 4 and 8 Hz are 3.981 and 7.943 Hz.
constexpr double nominal = 0.99;

enum class ClassCheck { met, exceeded, unknown };

ClassCheck judge(const Eigen::VectorXd& band_velocity, const std::vector<OctaveBand>& bands,
                 const VibrationCriterion& criterion) {
  ClassCheck judgement = ClassCheck::met;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double velocity = band_velocity(static_cast<Eigen::Index>(i));
    if (!criterion.applies(bands[i].centre_hz)) continue;
    if (velocity > criterion.limit(bands[i].centre_hz)) return ClassCheck::exceeded;
    if (std::isnan(velocity)) judgement = ClassCheck::unknown;
  }
  return judgement;
}

std::vector<OctaveBand> bands_of(const Eigen::VectorXd& band_velocity) {
  const std::vector<OctaveBand> bands = third_octave_bands();
  if (band_velocity.size() != static_cast<Eigen::Index>(bands.size())) {
    throw std::invalid_argument("vibration_class: expected " + std::to_string(bands.size()) +
                                " bands, got " + std::to_string(band_velocity.size()));
  }
  return bands;
}

}  // namespace

bool VibrationCriterion::applies(double frequency_hz) const {
  return frequency_hz >= nominal * lowest_hz;
}

double VibrationCriterion::limit(double frequency_hz) const {
  constexpr double corner_hz = 8;
  if (!applies(frequency_hz)) return infinity;
  const bool relaxed = lowest_hz > 1 && frequency_hz < nominal * corner_hz;
  return relaxed ? velocity * corner_hz / frequency_hz : velocity;
}

const std::vector<VibrationCriterion>& vibration_criteria() {
  static const std::vector<VibrationCriterion> criteria = {
      {"VC-A", 50e-6, 4},   {"VC-B", 25e-6, 4},   {"VC-C", 12.5e-6, 1}, {"VC-D", 6.25e-6, 1},
      {"VC-E", 3.12e-6, 1}, {"VC-F", 1.56e-6, 1}, {"VC-G", 0.78e-6, 1}};
  return criteria;
}

std::string vibration_class(const Eigen::VectorXd& band_velocity) {
  const std::vector<OctaveBand> bands = bands_of(band_velocity);
  std::string met = "above VC-A";
  for (const VibrationCriterion& criterion : vibration_criteria()) {
    const ClassCheck judgement = judge(band_velocity, bands, criterion);
    if (judgement == ClassCheck::exceeded) continue;
    if (judgement == ClassCheck::unknown) return "not known";
    met = criterion.name;
  }
  return met;
}

bool exceeds(const Eigen::VectorXd& band_velocity, const std::string& criterion) {
  const std::vector<OctaveBand> bands = bands_of(band_velocity);
  for (const VibrationCriterion& one : vibration_criteria()) {
    if (one.name == criterion) return judge(band_velocity, bands, one) == ClassCheck::exceeded;
  }
  throw std::out_of_range("exceeds: " + criterion + " is no vibration criterion");
}

}  // namespace stillframe::report

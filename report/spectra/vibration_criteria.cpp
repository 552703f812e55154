#include "report/spectra/vibration_criteria.hpp"

#include <stdexcept>

#include "report/spectra/spectra.hpp"

namespace stillframe::report {

namespace {

bool meets(const Eigen::VectorXd& band_velocity, const std::vector<OctaveBand>& bands,
           const VibrationCriterion& criterion) {
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double velocity = band_velocity(static_cast<Eigen::Index>(i));
    if (!(velocity <= criterion.limit(bands[i].centre_hz))) return false;
  }
  return true;
}

}  // namespace

double VibrationCriterion::limit(double frequency_hz) const {
  // The exact centre of the 8 Hz band is 7.943 Hz; that band belongs to the flat part.
  const double corner_hz = 8;
  const bool below = frequency_hz < 0.99 * corner_hz;
  return relaxed_below_8_hz && below ? velocity * corner_hz / frequency_hz : velocity;
}

const std::vector<VibrationCriterion>& vibration_criteria() {
  static const std::vector<VibrationCriterion> criteria = {
      {"VC-A", 50e-6, true},    {"VC-B", 25e-6, true},    {"VC-C", 12.5e-6, false},
      {"VC-D", 6.25e-6, false}, {"VC-E", 3.12e-6, false}, {"VC-F", 1.56e-6, false},
      {"VC-G", 0.78e-6, false}};
  return criteria;
}

std::string vibration_class(const Eigen::VectorXd& band_velocity) {
  const std::vector<OctaveBand> bands = third_octave_bands();
  if (band_velocity.size() != static_cast<Eigen::Index>(bands.size())) {
    throw std::invalid_argument("vibration_class: expected " + std::to_string(bands.size()) +
                                " bands, got " + std::to_string(band_velocity.size()));
  }
  std::string met = "above VC-A";
  for (const VibrationCriterion& criterion : vibration_criteria()) {
    if (meets(band_velocity, bands, criterion)) met = criterion.name;
  }
  return met;
}

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/gains.hpp"
#include "controller/io.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::controller {

/// The plant of a gains file with its instruments and its delay, exactly sampled, on a floor that
/// trembles by sines from 2 to 50 Hz. Construction is set-up; the rest is hot.
class SimulatedPlant {
 public:
  /// floor_rms: m/s^2, of each acceleration.
  SimulatedPlant(const Gains& gains, double floor_rms);
  /// Of any plant, whose y are what accelerometers on the frame read.
  SimulatedPlant(SampledPlant plant, double floor_rms);

  /// What is measured at the sample that it stands at: sigma, applied, and as much of floor and
  /// frame as there is room for.
  void read(Measurement& measurement) noexcept;
  /// Goes on by a sample; force: m, N, commanded for the sample that was read.
  void advance(const Eigen::VectorXd& force) noexcept;

  double sample_time() const noexcept { return plant_.sample_time; }
  const Eigen::VectorXd& y() const noexcept { return y_; }  ///< what the loop is judged by

 private:
  SampledPlant plant_;
  double floor_rms_;
  bool has_frame_ = false;
  std::int64_t k_ = 0;
  Eigen::MatrixXd on_its_way_, reports_;  ///< m x delay + 1, m x report_age + 1, rings
  Eigen::VectorXd x_, next_, w_, before_, y_;
  Eigen::ArrayXd turn_;    ///< rad a sample, of each sine
  Eigen::ArrayXXd phase_;  ///< rad, sine x acceleration
};

}  // namespace stillframe::controller

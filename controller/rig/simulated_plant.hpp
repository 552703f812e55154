#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

#include "controller/gains.hpp"
#include "controller/io.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::controller {

/// A floor that trembles: noise between 2 and 50 Hz, each acceleration by itself. Construction is
/// set-up; advance is hot.
class Tremor {
 public:
  /// rms: m/s^2, of each of n accelerations; sample_time: s.
  Tremor(double rms, Eigen::Index n, double sample_time, unsigned seed);
  void advance(Eigen::VectorXd& w) noexcept;

 private:
  double step(Eigen::Ref<Eigen::Array<double, 1, Eigen::Dynamic>, 0, Eigen::InnerStride<>> state,
              double noise) const noexcept;

  double follows_, rests_, size_ = 0;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Eigen::ArrayXXd states_;  ///< n x 3
};

/// The plant of a gains file with its instruments and its delay, exactly sampled, on a floor that
/// trembles. Construction is set-up; the rest is hot.
class SimulatedPlant {
 public:
  /// floor_rms: m/s^2, of each acceleration.
  SimulatedPlant(const Gains& gains, double floor_rms);
  /// Of any plant, whose y are what accelerometers on the frame read.
  SimulatedPlant(SampledPlant plant, double floor_rms, unsigned seed = 1);

  /// What is measured at the sample that it stands at: sigma, applied, and as much of floor and
  /// frame as there is room for.
  void read(Measurement& measurement) noexcept;
  /// Goes on by a sample; force: m, N, commanded for the sample that was read.
  void advance(const Eigen::VectorXd& force) noexcept;

  double sample_time() const noexcept { return plant_.sample_time; }
  const Eigen::VectorXd& y() const noexcept { return y_; }  ///< what the loop is judged by

 private:
  SampledPlant plant_;
  Tremor floor_;
  bool has_frame_ = false;
  std::int64_t k_ = 0;
  Eigen::MatrixXd on_its_way_, reports_;  ///< m x delay + 1, m x report_age + 1, rings
  Eigen::VectorXd x_, next_, w_, before_, y_;
};

}  // namespace stillframe::controller

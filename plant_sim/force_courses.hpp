#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/mechanics/scene/disturbances.hpp"

namespace stillframe {

/// A force that is held over each sample, in N. What has a closed form is held at its mean over the
/// sample, so that the impulse is right however short it is; a sweep at its value in the middle.
/// Set-up: construction; hot: at().
class ForceCourse {
 public:
  /// sample_time: s. Errors: InputError at disturbance.place for frequencies that samples cannot
  /// hold, and for a recording that is missing, unsound or too short.
  ForceCourse(const SceneDisturbance& disturbance, double sample_time);

  /// The force (N) held over sample k, from 0 up.
  double at(std::int64_t k) const noexcept;

 private:
  std::variant<ForceStep, ForceImpact, ForceSine, ForceSweep, ForceNoise, ForceRecording> force_;
  double sample_time_;
  Eigen::VectorXd table_;   ///< of noise one period, of a recording all of it
  std::int64_t begin_ = 0;  ///< sample with which the table begins
};

}  // namespace stillframe

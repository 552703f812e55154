#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::floor {

/// What the channels of a source are: the world axes x, y, z of a floor that moves as one body
/// without rotation, or the floor inputs of the scene, each on its own.
enum class FloorChannels { translations, inputs };

/// The prescribed acceleration of the floor, held over each sample.
///   w(t) = w[k] for k T_s <= t < (k + 1) T_s.
/// The same k always gives the same numbers, in any order of k. Made in set-up; sample() is hot.
class FloorSource {
 public:
  virtual ~FloorSource() = default;

  virtual FloorChannels meaning() const noexcept = 0;
  /// Number of channels: 3 for translations, else the number of floor inputs.
  virtual Eigen::Index channels() const noexcept = 0;
  /// Number of samples that the source has, at least one; k runs from 0 to n_samples() - 1.
  virtual std::int64_t n_samples() const noexcept = 0;
  /// Writes w[k] (m/s^2, channels() entries) to out; zeros where k is outside 0 ... n_samples()
  /// - 1. Hot: noexcept, no allocation. out must have channels() entries.
  virtual void sample(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept = 0;
};

}  // namespace stillframe::floor

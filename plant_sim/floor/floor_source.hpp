#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::floor {

/// What the channels of a source are: of a floor that moves as one body the world axes x, y, z and
/// small rotations rx, ry, rz about lines through the origin; the floor inputs of the scene, each
/// on its own; or the six of the rigid floor and then the inputs.
enum class FloorChannels { rigid, inputs, rigid_and_inputs };

/// The prescribed acceleration of the floor, held over each sample.
///   w(t) = w[k] for k T_s <= t < (k + 1) T_s.
/// The same k always gives the same numbers, in any order of k. Made in set-up; sample() and add()
/// are hot.
class FloorSource {
 public:
  virtual ~FloorSource() = default;

  virtual FloorChannels meaning() const noexcept = 0;
  /// Number of channels: 6 for a rigid floor, one for each input.
  virtual Eigen::Index channels() const noexcept = 0;
  /// Number of samples that the source has, at least one; k runs from 0 to n_samples() - 1.
  virtual std::int64_t n_samples() const noexcept = 0;
  /// Whether a channel is other than zero at any time. Set-up.
  virtual bool moves(Eigen::Index channel) const = 0;
  /// Adds w[k] (m/s^2, rad/s^2; channels() entries) to out; nothing where k is outside 0 ...
  /// n_samples() - 1. Hot: noexcept, no allocation. out must have channels() entries.
  virtual void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept = 0;
  /// The same written to out. Hot.
  void sample(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept {
    out.setZero();
    add(k, out);
  }
};

}  // namespace stillframe::floor

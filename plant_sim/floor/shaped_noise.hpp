#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "plant_sim/floor/density.hpp"
#include "plant_sim/floor/floor_source.hpp"

namespace stillframe::floor {

/// The spectral shape of a noise, and how often it repeats.
struct NoiseShape {
  Density density;
  std::uint64_t seed = 1;
  double high_pass_hz = 0.0;  ///< 0: none
  double rate = 0.0;          ///< samples a second
  std::int64_t period = 0;    ///< samples; made longer to next_quick_length of it
};

/// One period of independent periodic noises, lines at all multiples of rate / period whose
/// amplitudes follow the density exactly and whose phases are random:
///   x[k] = sum_b sqrt(2 S(f_b) |H(f_b)|^2 df / g(f_b)^2) cos(2 pi b k / n + phi_b),
/// |H|^2 = 1 / (1 + (high_pass / f)^8). `positions` divides by g = held_acceleration_gain, so that
/// held_acceleration of the result has the density; without it g = 1. The mean is zero.
/// Returns n x channels. Source: M. Shinozuka, C.-M. Jan, J. Sound Vib. 25 (1972) 111-128. Set-up.
Eigen::MatrixXd periodic_noise(const NoiseShape& shape, const std::vector<Eigen::Index>& channels,
                               bool positions);

/// Shaped noise on several channels, each on its own, faded in and out; repeats after its period.
/// It is faded as a position, from and to rest: integrated, it does not drift. Set-up: the
/// constructor; hot: add().
class NoiseFloor final : public FloorSource {
 public:
  /// patterns: channels x noises, what each noise moves; positions: period x noises (m, rad);
  /// rate: 1/s; fade: samples at each end, at most half of n_samples.
  NoiseFloor(FloorChannels meaning, Eigen::MatrixXd patterns, Eigen::MatrixXd positions,
             double rate, std::int64_t n_samples, std::int64_t fade);

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return patterns_.rows(); }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  bool moves(Eigen::Index channel) const override { return !patterns_.row(channel).isZero(0); }
  void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override;

 private:
  /// How far the noise is faded in at sample k: zero from n_samples - 1 on, and up to 0.
  double weight(std::int64_t k) const noexcept;

  FloorChannels meaning_;
  Eigen::MatrixXd patterns_, positions_;
  double rate_;
  std::int64_t n_samples_, fade_;
};

}  // namespace stillframe::floor

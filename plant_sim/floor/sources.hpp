#pragma once

#include <utility>

#include "plant_sim/floor/floor_source.hpp"

namespace stillframe::floor {

/// A floor whose every sample was computed beforehand. Set-up: the constructor; hot: sample().
class TabulatedFloor final : public FloorSource {
 public:
  /// acceleration: channels x samples, m/s^2.
  TabulatedFloor(FloorChannels meaning, Eigen::MatrixXd acceleration)
      : meaning_(meaning), acceleration_(std::move(acceleration)) {}

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return acceleration_.rows(); }
  std::int64_t n_samples() const noexcept override { return acceleration_.cols(); }
  void sample(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override {
    if (k < 0 || k >= acceleration_.cols()) {
      out.setZero();
    } else {
      out = acceleration_.col(k);
    }
  }

 private:
  FloorChannels meaning_;
  Eigen::MatrixXd acceleration_;
};

/// A floor that does not move. Set-up: the constructor; hot: sample().
class StillFloor final : public FloorSource {
 public:
  StillFloor(Eigen::Index channels, std::int64_t n_samples)
      : channels_(channels), n_samples_(n_samples) {}

  FloorChannels meaning() const noexcept override { return FloorChannels::inputs; }
  Eigen::Index channels() const noexcept override { return channels_; }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  void sample(std::int64_t, Eigen::Ref<Eigen::VectorXd> out) const noexcept override {
    out.setZero();
  }

 private:
  Eigen::Index channels_;
  std::int64_t n_samples_;
};

}  // namespace stillframe::floor

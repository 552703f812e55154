#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "plant_sim/floor/floor_source.hpp"

namespace stillframe::floor {

/// A floor whose every sample was computed beforehand. Set-up: the constructor; hot: add().
class TabulatedFloor final : public FloorSource {
 public:
  /// acceleration: channels x samples, m/s^2 and rad/s^2.
  TabulatedFloor(FloorChannels meaning, Eigen::MatrixXd acceleration)
      : meaning_(meaning), acceleration_(std::move(acceleration)) {}

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return acceleration_.rows(); }
  std::int64_t n_samples() const noexcept override { return acceleration_.cols(); }
  bool moves(Eigen::Index channel) const override { return !acceleration_.row(channel).isZero(0); }
  void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override {
    if (k >= 0 && k < acceleration_.cols()) out += acceleration_.col(k);
  }

 private:
  FloorChannels meaning_;
  Eigen::MatrixXd acceleration_;
};

/// A floor that does not move. Set-up: the constructor; hot: add().
class StillFloor final : public FloorSource {
 public:
  StillFloor(Eigen::Index channels, std::int64_t n_samples)
      : channels_(channels), n_samples_(n_samples) {}

  FloorChannels meaning() const noexcept override { return FloorChannels::inputs; }
  Eigen::Index channels() const noexcept override { return channels_; }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  bool moves(Eigen::Index) const override { return false; }
  void add(std::int64_t, Eigen::Ref<Eigen::VectorXd>) const noexcept override {}

 private:
  Eigen::Index channels_;
  std::int64_t n_samples_;
};

/// One course of motion, m/s^2 or rad/s^2, along a fixed pattern of channels. Set-up: the
/// constructor; hot: add().
///   w[k] = pattern course[k - begin]
class PatternFloor final : public FloorSource {
 public:
  PatternFloor(FloorChannels meaning, Eigen::VectorXd pattern, Eigen::VectorXd course,
               std::int64_t begin, std::int64_t n_samples)
      : meaning_(meaning),
        pattern_(std::move(pattern)),
        course_(std::move(course)),
        begin_(begin),
        n_samples_(n_samples) {}

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return pattern_.size(); }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  bool moves(Eigen::Index channel) const override { return pattern_(channel) != 0; }
  void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override {
    const std::int64_t i = k - begin_;
    if (i >= 0 && i < course_.size() && k < n_samples_) out += course_(i) * pattern_;
  }

 private:
  FloorChannels meaning_;
  Eigen::VectorXd pattern_, course_;
  std::int64_t begin_, n_samples_;
};

/// Several sources at once, as long as the longest; one that has ended adds nothing more. Set-up:
/// the constructor; hot: add().
class SumFloor final : public FloorSource {
 public:
  /// inputs: number of floor inputs of the scene. Errors: std::invalid_argument without parts.
  SumFloor(std::vector<std::unique_ptr<FloorSource>> parts, Eigen::Index inputs);

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return channels_; }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  bool moves(Eigen::Index channel) const override;
  void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override;

 private:
  struct Part {
    std::unique_ptr<FloorSource> source;
    Eigen::Index offset;  ///< of its channels among those of the sum
  };
  std::vector<Part> parts_;
  FloorChannels meaning_;
  Eigen::Index channels_ = 0;
  std::int64_t n_samples_ = 0;
};

}  // namespace stillframe::floor

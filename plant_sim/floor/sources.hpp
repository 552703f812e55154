#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "plant_sim/floor/floor_source.hpp"

namespace stillframe::floor {

/// Courses of motion that were computed beforehand, each along a fixed pattern of channels.
///   w[k] = P c[k - begin], and nothing before and behind the courses
/// Set-up: construction; hot: add().
class TabulatedFloor final : public FloorSource {
 public:
  /// patterns: P, channels x courses; courses: courses x samples, m/s^2 and rad/s^2; n_samples: of
  /// the floor.
  TabulatedFloor(FloorChannels meaning, Eigen::MatrixXd patterns, Eigen::MatrixXd courses,
                 std::int64_t begin, std::int64_t n_samples)
      : meaning_(meaning),
        patterns_(std::move(patterns)),
        courses_(std::move(courses)),
        begin_(begin),
        n_samples_(n_samples) {}
  /// A course for each channel, from the first sample to the last.
  TabulatedFloor(FloorChannels meaning, Eigen::MatrixXd courses)
      : meaning_(meaning),
        patterns_(Eigen::MatrixXd::Identity(courses.rows(), courses.rows())),
        courses_(std::move(courses)),
        begin_(0),
        n_samples_(courses_.cols()) {}

  FloorChannels meaning() const noexcept override { return meaning_; }
  Eigen::Index channels() const noexcept override { return patterns_.rows(); }
  std::int64_t n_samples() const noexcept override { return n_samples_; }
  bool moves(Eigen::Index channel) const override;
  void add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept override {
    const std::int64_t i = k - begin_;
    if (i < 0 || i >= courses_.cols() || k >= n_samples_) return;
    out.noalias() += patterns_ * courses_.col(i);
  }

 private:
  FloorChannels meaning_;
  Eigen::MatrixXd patterns_, courses_;
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

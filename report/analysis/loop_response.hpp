#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "core/control/close_loop.hpp"

namespace stillframe::report {

/// When a loop took hold of its frame, which was passive before, by sequence numbers.
struct Takeover {
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max() / 2;

  std::int64_t from = never;  ///< in the sample behind it the law begins, at rest
  std::int64_t full = never;  ///< from here on its whole command acts, smooth_step between
  /// The means of the force sensors over these samples were taken for offsets and are subtracted,
  /// of those legs (m) that have a 1 in `offset`, not a 0.
  std::int64_t heard_from = 0, heard_to = -1;
  Eigen::VectorXd offset = {};

  /// Of the law's command, what acts.
  double share(std::int64_t seq) const;
};

/// A loop that was not closed from the beginning on.
struct LateLoop {
  Takeover when;
  GainedLoop loop;
};

/// What a sampled loop makes of its inputs, sample by sample, from rest. Set-up.
class LoopResponse {
 public:
  explicit LoopResponse(SampledLoop loop);
  /// What the law hears it answers but for what was taken for offsets of its sensors.
  explicit LoopResponse(LateLoop loop);
  /// The inputs that travel with the next measurements, a row each: the outputs of these.
  Eigen::MatrixXd follow(const Eigen::MatrixXd& inputs);
  /// At rest in sample seq, which is the next.
  void rest_until(std::int64_t seq);
  std::int64_t next() const { return next_; }

 private:
  Eigen::MatrixXd step(const Eigen::MatrixXd& inputs);
  void take_hold(std::int64_t seq);

  SampledLoop loop_;
  std::optional<LateLoop> late_;
  Eigen::VectorXd state_, scratch_, input_;
  Eigen::VectorXd heard_;  ///< m, N, sums
  double share_ = -1;      ///< none yet
  std::int64_t next_ = 0;
};

/// Forces that act on a frame besides its floor, as its scene has them.
struct ForceModel {
  SampledLoop loop;  ///< from the forces to accelerations
  /// N, held over sample k, one of each input of the loop; k may be -1, before the run.
  std::function<Eigen::VectorXd(std::int64_t)> at;
  std::optional<LateLoop> late = {};
};

/// What a loop makes of forces whose whole course is known: a log's gaps are none here. Set-up.
class ForceResponse {
 public:
  explicit ForceResponse(ForceModel model);
  /// The accelerations of n measurements from seq on, a row each. Errors: std::invalid_argument for
  /// a seq before what was asked last.
  Eigen::MatrixXd at(std::int64_t seq, Eigen::Index n);

 private:
  Eigen::MatrixXd follow(Eigen::Index n);

  Eigen::Index n_forces_;
  LoopResponse response_;
  std::function<Eigen::VectorXd(std::int64_t)> forces_;
};

}  // namespace stillframe::report

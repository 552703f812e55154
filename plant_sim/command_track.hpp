#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>

namespace stillframe {

/// The commands that have come, by the sample that each belongs to. A plant that was stopped finds
/// them all when it goes on, and gives each its own time: a simulated frame must not be kicked by
/// what happens to the clock of its simulator.
class CommandTrack {
 public:
  explicit CommandTrack(Eigen::Index n_legs) : force_(Eigen::VectorXd::Zero(n_legs)) {}

  enum class Result { taken, duplicate, too_many };

  /// A command (n_legs, N) that belongs to sample seq.
  Result add(std::int64_t seq, const Eigen::Ref<const Eigen::VectorXd>& force);

  /// Goes on to the newest command of sample k or before.
  void advance_to(std::int64_t k);

  std::int64_t seq() const { return seq_; }  ///< of the command that stands, -1 before the first
  const Eigen::VectorXd& force() const { return force_; }  ///< n_legs, N

 private:
  std::map<std::int64_t, Eigen::VectorXd> waiting_;
  std::int64_t seq_ = -1;
  Eigen::VectorXd force_;
};

}  // namespace stillframe

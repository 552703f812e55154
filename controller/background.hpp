#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace stillframe::controller {

/// A thread for what may hang: a terminal that nobody reads, a disk that does not answer. Jobs are
/// done one after the other; where more wait than there is room for, the oldest goes and is
/// counted, so that whoever gives a job never waits for one. Set-up.
class Background {
 public:
  /// capacity: jobs that may wait, 1 or more. The thread is an ordinary one: begin before the
  /// calling thread gets a priority, which it would inherit.
  explicit Background(std::size_t capacity);
  /// Leaves a job that hangs to itself; the others are done if nothing holds them up.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// A job must not refer to what may be gone before it is done. What it throws is lost.
  void give(std::function<void()> job);
  /// Waits until nothing is left to be done; false if something still is after so long.
  bool finish(double limit_s);
  std::int64_t n_dropped() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace stillframe::controller

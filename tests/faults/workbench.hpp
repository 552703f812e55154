#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <vector>

#include "tests/faults/bystander.hpp"
#include "tests/faults/passive_frame.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::faults {

/// What all runs of a table share: a folder with the scene and its gains, and the passive frame.
class Workbench {
 public:
  /// Writes the metrology frame with damped legs (N s/m each) on the ordinary floor into a new
  /// folder, and designs its gains. Errors: std::runtime_error.
  explicit Workbench(double leg_damping = default_leg_damping);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// 1.1 % of critical in the slowest mode, 3.9 % in the fastest. Without it the passive frame
  /// would resonate so much that no active one could look bad beside it.
  static constexpr double default_leg_damping = 1000;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path scene() const { return folder_ / "scene.yaml"; }
  std::filesystem::path gains() const { return folder_ / "gains.yaml"; }
  double rate_hz() const { return 1000; }

  /// The witness of what the machine does.
  Bystander& bystander() { return bystander_; }

  /// Length of the passive run whose peak everything is compared with: the same for every fault.
  static constexpr std::int64_t n_reference = 60'000;

  /// The first n samples of the passive frame, from any thread.
  std::vector<Accelerations> passive(std::int64_t n);
  /// As PassiveFrame::held_from, from any thread.
  std::vector<Accelerations> held_from(const std::vector<Forces>& applied, std::int64_t from,
                                       std::int64_t n);

 private:
  test::ScratchFolder scratch_;
  const std::filesystem::path& folder_ = scratch_.path();
  Bystander bystander_;
  std::mutex mutex_;
  std::unique_ptr<PassiveFrame> passive_;
};

}  // namespace stillframe::faults

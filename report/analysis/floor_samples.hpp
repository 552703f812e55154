#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "report/log/log_scan.hpp"

namespace stillframe::report {

/// The floor inputs of a run at every so manieth sample, by which two logs show whether they are of
/// one floor: what run_info says of a recorded floor is the name of its file.
class FloorSamples {
 public:
  FloorSamples() = default;
  /// At most 2^19 numbers (4 MB) of the n_samples that are announced.
  explicit FloorSamples(const stillframe_msgs::run_info_t& info);

  void add(const SampleBlock& block);
  /// Whether all samples that both logs hold are the same, those that are not finite aside. True
  /// where they hold none in common, false for runs of other inputs or another length.
  bool agrees(const FloorSamples& other) const;

 private:
  Eigen::Index n_floor_ = 0;
  std::int64_t every_ = 1, most_ = 0;  ///< one in every_ samples, most_ of them
  std::vector<double> values_;         ///< of sample i every_ from i n_floor on; NaN: not there
};

}  // namespace stillframe::report

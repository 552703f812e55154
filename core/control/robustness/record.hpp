#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/control/robustness/monte_carlo.hpp"

namespace stillframe::robustness {

/// All that is known of a set of samples: what was asked, and the tally of the shards done so far.
struct Record {
  std::string scene, scene_hash;  ///< title, and hash of scene and controller
  SceneUncertainty uncertainty;
  std::vector<std::string> parameters;  ///< p, names
  Eigen::VectorXd frequencies_hz;       ///< n_f
  double sample_time = 0;               ///< s
  std::uint64_t seed = 0, samples = 0;  ///< of all shards together
  std::uint64_t n_shards = 1;
  std::set<std::uint64_t> shards;  ///< those done, from 1; {1} of 1 if all are
  Outcome nominal;
  Tally tally{0};

  bool complete() const { return shards.size() == n_shards; }
};

/// In what two records are not of one set of samples, in words; empty if they are.
std::string difference_between(const Record& a, const Record& b);

/// A record, and how it is called in messages.
struct NamedRecord {
  std::string name;
  Record record;
};

/// The record of all shards together; that of a complete set does not tell in which shards it was
/// done. Errors: InputError naming two records that are not of one set of samples and in what they
/// differ, or that have a shard in common.
Record merge_records(std::vector<NamedRecord> records);

}  // namespace stillframe::robustness

#include "core/control/robustness/record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/errors/input_error.hpp"

namespace stillframe::robustness {

namespace {

std::array<double, 9> numbers_of(const SceneUncertainty& u) {
  return {u.stiffness,         u.damping,       u.mass,        u.inertia,      u.centre_of_mass_m,
          u.leg_direction_rad, u.actuator_gain, u.sensor_gain, u.delay_samples};
}

}  // namespace

std::string difference_between(const Record& a, const Record& b) {
  if (a.scene_hash != b.scene_hash) {
    return "scene or controller (scene_hash " + a.scene_hash + " and " + b.scene_hash + ")";
  }
  if (a.seed != b.seed) {
    return "seed (" + std::to_string(a.seed) + " and " + std::to_string(b.seed) + ")";
  }
  if (a.samples != b.samples) {
    return "number of samples of all shards together (" + std::to_string(a.samples) + " and " +
           std::to_string(b.samples) + ")";
  }
  if (numbers_of(a.uncertainty) != numbers_of(b.uncertainty)) return "uncertainty";
  if (a.frequencies_hz.size() != b.frequencies_hz.size() || a.frequencies_hz != b.frequencies_hz ||
      a.parameters != b.parameters) {
    return "parameters or frequencies: they come from different versions of the program";
  }
  return "";
}

namespace {

void require_same_set(const NamedRecord& a, const NamedRecord& b) {
  std::string differs = difference_between(a.record, b.record);
  const double radius = a.record.nominal.radius, other = b.record.nominal.radius;
  // Other processors round otherwise, ill-conditioned eigenvalues by far less than this.
  if (differs.empty() && !(std::abs(radius - other) <= 1e-6 * radius)) {
    differs = "the spectral radius of the unperturbed loop (" + std::to_string(radius) + " and " +
              std::to_string(other) + ")";
  }
  if (!differs.empty()) {
    throw InputError(a.name + " and " + b.name + " do not belong together: they differ in " +
                     differs);
  }
  if (a.record.n_shards == b.record.n_shards) return;
  if (a.record.n_shards == 1 || b.record.n_shards == 1) {
    const bool first = a.record.n_shards == 1;
    throw InputError((first ? a : b).name + " holds all samples, those of " + (first ? b : a).name +
                     " among them: every sample may count once");
  }
  throw InputError(a.name + " is of " + std::to_string(a.record.n_shards) + " shards and " +
                   b.name + " of " + std::to_string(b.record.n_shards) +
                   ": only shards of one division can be merged");
}

}  // namespace

Record merge_records(std::vector<NamedRecord> records) {
  if (records.empty()) throw InputError("nothing to merge");
  // What is not summed comes from the record with the first shard, in whatever order they are
  // given.
  std::stable_sort(records.begin(), records.end(), [](const NamedRecord& a, const NamedRecord& b) {
    return a.record.shards < b.record.shards;
  });
  std::map<std::uint64_t, std::string> owners;
  for (const NamedRecord& part : records) {
    require_same_set(records.front(), part);
    for (const std::uint64_t shard : part.record.shards) {
      const auto [owner, is_new] = owners.emplace(shard, part.name);
      if (is_new) continue;
      throw InputError("shard " + std::to_string(shard) + "/" +
                       std::to_string(part.record.n_shards) + " is in " + owner->second +
                       " and in " + part.name + ": every sample may count once");
    }
  }
  Record all = std::move(records.front().record);
  for (size_t i = 1; i < records.size(); ++i) {
    all.tally.merge(records[i].record.tally);
    all.shards.insert(records[i].record.shards.begin(), records[i].record.shards.end());
  }
  if (all.complete()) {
    all.n_shards = 1;
    all.shards = {1};
  }
  return all;
}

}  // namespace stillframe::robustness

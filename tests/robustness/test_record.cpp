#include <gtest/gtest.h>

#include "core/control/robustness/record.hpp"
#include "core/errors/input_error.hpp"
#include "tests/robustness/frame.hpp"

namespace stillframe::robustness {
namespace {

Record part(std::uint64_t number, std::uint64_t of) {
  Record record;
  record.scene_hash = "a";
  record.uncertainty.stiffness = 0.1;
  record.parameters = {"leg stiffness"};
  record.frequencies_hz = Eigen::Vector2d(1, 5);
  record.seed = 3;
  record.samples = 40;
  record.n_shards = of;
  record.shards = {number};
  record.tally = Tally(2);
  // So that it shows whose was kept, and as another processor would round it.
  record.nominal.radius = 1 - 1e-9 * static_cast<double>(number);
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.1;
  record.tally =
      run_samples(Cart{.m = 2, .k = 800, .kappa = 0.5, .sample_time = 0.01}.evaluator(uncertainty),
                  {record.seed, record.samples, {number, of}}, 1);
  return record;
}

std::string error_of(std::vector<NamedRecord> records) {
  try {
    merge_records(std::move(records));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Merge, AllShardsAreTheWhole) {
  const Record whole = part(1, 1);
  const Record merged = merge_records({{"c", part(3, 3)}, {"a", part(1, 3)}, {"b", part(2, 3)}});
  EXPECT_TRUE(merged.complete());
  EXPECT_EQ(merged.n_shards, 1u);
  EXPECT_EQ(merged.shards, std::set<std::uint64_t>{1});
  EXPECT_EQ(merged.nominal.radius, 1 - 1e-9);
  EXPECT_EQ(merged.tally.n_samples(), 40u);
  EXPECT_EQ(merged.tally.peak.most, whole.tally.peak.most);
  EXPECT_EQ(merged.tally.peak_db.counts, whole.tally.peak_db.counts);
}

TEST(Merge, PartsOfPartsCanFollowLater) {
  const Record two = merge_records({{"c", part(3, 3)}, {"b", part(2, 3)}});
  EXPECT_FALSE(two.complete());
  EXPECT_EQ(two.shards, (std::set<std::uint64_t>{2, 3}));
  EXPECT_EQ(two.n_shards, 3u);
  EXPECT_TRUE(merge_records({{"two", two}, {"a", part(1, 3)}}).complete());
}

TEST(Merge, RefusesWhatCountsTwice) {
  EXPECT_EQ(error_of({{"a", part(1, 3)}, {"b", part(2, 3)}, {"c", part(2, 3)}}),
            "shard 2/3 is in b and in c: every sample may count once");
  EXPECT_EQ(error_of({{"part", part(2, 3)}, {"all", part(1, 1)}}),
            "all holds all samples, those of part among them: every sample may count once");
  EXPECT_EQ(error_of({{"a", part(1, 1)}, {"b", part(1, 1)}}),
            "shard 1/1 is in a and in b: every sample may count once");
}

TEST(Merge, RefusesWhatDoesNotBelongTogether) {
  const auto with_change = [](void (*change)(Record&)) {
    Record other = part(2, 3);
    change(other);
    return error_of({{"a", part(1, 3)}, {"b", other}});
  };
  EXPECT_EQ(with_change([](Record& r) { r.seed = 4; }),
            "a and b do not belong together: they differ in seed (3 and 4)");
  EXPECT_NE(with_change([](Record& r) { r.scene_hash = "b"; }).find("scene_hash a and b"),
            std::string::npos);
  EXPECT_NE(with_change([](Record& r) { r.samples = 41; }).find("(40 and 41)"), std::string::npos);
  EXPECT_NE(with_change([](Record& r) { r.uncertainty.delay_samples = 1; }).find("uncertainty"),
            std::string::npos);
  EXPECT_NE(with_change([](Record& r) { r.frequencies_hz(1) = 6; }).find("frequencies"),
            std::string::npos);
  EXPECT_NE(with_change([](Record& r) { r.parameters.front() = "delay"; }).find("parameters"),
            std::string::npos);
  EXPECT_NE(with_change([](Record& r) { r.nominal.radius = 2; }).find("unperturbed loop (1.0"),
            std::string::npos);
  EXPECT_EQ(with_change([](Record& r) { r.n_shards = 4; }),
            "a is of 3 shards and b of 4: only shards of one division can be merged");
}

}  // namespace
}  // namespace stillframe::robustness

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "tests/faults/passive_frame.hpp"

namespace stillframe::faults {
namespace {

constexpr std::int64_t n = 1500;

std::filesystem::path scene_file() {
  return std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config/scenes/metrology_frame.yaml";
}

/// The nonlinear plant of a run, under forces that are held until each sample.
std::vector<Accelerations> simulated(const std::vector<Forces>& applied) {
  const Scene scene = read_scene(scene_file(), {});
  const auto block = read_floor(scene, {});
  Plant plant(scene, floor::make_floor_source(
                         floor::read_floor_block(block->reader, scene.controller->sample_rate_hz,
                                                 static_cast<Index>(scene.inputs.size()))));
  std::vector<Accelerations> result(1);
  for (std::size_t k = 1; k < applied.size(); ++k) {
    EXPECT_EQ(plant.advance(Eigen::Map<const Eigen::VectorXd>(applied[k].data(), 6)), "");
    const Eigen::VectorXd& frame = plant.read().frame_acceleration;
    std::copy_n(frame.begin(), 6, result.emplace_back().begin());
  }
  return result;
}

/// Of the peaks: the integrator's local error is 1e-5 of the largest motion within a sample, which
/// a resonance with no damping adds up over some ten periods; the nonlinearity is 1e-6.
void expect_same(const std::vector<Accelerations>& a, const std::vector<Accelerations>& b) {
  ASSERT_EQ(a.size(), b.size());
  const Accelerations size = peak(b, 0, n);
  for (std::size_t k = 0; k < a.size(); ++k) {
    for (std::size_t i = 0; i < 6; ++i) ASSERT_NEAR(a[k][i], b[k][i], 1e-3 * size[i]) << k;
  }
}

TEST(PassiveFrame, IsThePlantWithoutForce) {
  PassiveFrame frame(scene_file());
  expect_same(frame.samples(n), simulated(std::vector<Forces>(n, Forces{})));
}

TEST(PassiveFrame, FollowsForcesAndThenHoldsThem) {
  constexpr std::int64_t from = 1000;
  std::mt19937_64 random(1);
  std::vector<Forces> applied(n, Forces{});
  for (std::size_t k = 1; k < applied.size(); ++k) {
    for (double& force : applied[k]) force = static_cast<double>(random() >> 11) * 0x1p-53;
  }
  std::vector<Forces> held = applied;
  for (std::size_t k = from; k < held.size(); ++k) held[k] = applied[from];
  PassiveFrame frame(scene_file());
  expect_same(frame.held_from(applied, from, n), simulated(held));
}

TEST(PassiveFrame, PeaksLeaveOutWhatWasNotSeen) {
  const std::vector<Accelerations> samples{{1, 1, 1, 1, 1, 1}, {-3, NAN, 0, 0, 0, 0}, {9}};
  EXPECT_EQ(peak(samples, 0, 2), (Accelerations{3, 1, 1, 1, 1, 1}));
  EXPECT_EQ(largest_ratio({1, 2, 3, 4, 5, 6}, {1, 1, 1, 1, 1, 2}), 5);
  EXPECT_TRUE(std::isnan(largest_ratio({1, 0, 3, 4, 5, 6}, {1, 0, 1, 1, 1, 2})));
}

}  // namespace
}  // namespace stillframe::faults

#include <gtest/gtest.h>

#include <cmath>

#include "core/numerics/infinity.hpp"
#include "report/log/sample_check.hpp"
#include "tests/report/log/run_fixture.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

std::vector<double> values_of(const stillframe_msgs::measurement_t& m) {
  std::vector<double> values = m.floor_acceleration;
  for (const auto* part : {&m.sigma, &m.applied_force, &m.frame_acceleration}) {
    values.insert(values.end(), part->begin(), part->end());
  }
  return values;
}

TEST(SampleCheck, NamesTheFirstValueThatIsNoNumber) {
  const char* names[] = {"floor acceleration of x", "floor acceleration of y",
                         "sigma of leg_1",          "sigma of leg_2",
                         "sigma of leg_3",          "applied force of leg_1",
                         "applied force of leg_2",  "applied force of leg_3",
                         "acceleration of frame_x", "acceleration of frame_y"};
  for (const double bad : {std::nan(""), infinity, -infinity, 1e300, -1.1e12}) {
    for (std::size_t i = 0; i < 10; ++i) {
      SampleCheck check(sample_info(1, 100));
      for (std::int64_t seq = 0; seq < 9; ++seq) {
        std::vector<double> values = values_of(sample_measurement(1, seq));
        if (seq == 3 || seq == 7) values[i] = bad;
        check.measurement(seq, values.data());
      }
      EXPECT_EQ(check.faults().n_not_finite, 2) << bad;
      EXPECT_EQ(check.faults().first_not_finite, std::string("seq 3, ") + names[i]) << bad;
    }
  }
}

// A measurement without a command has a NaN in the block where the command would be.
TEST(SampleCheck, ACommandThatIsNotThereIsNotOneOfNoNumbers) {
  const test::ScratchFolder folder;
  const auto faults = [&](double force) {
    {
      LogWriter log(folder / "run.lcm");
      log.write(channels::run_info, sample_info(1, 10));
      for (std::int64_t seq = 0; seq < 10; ++seq) {
        log.write(channels::measurement, sample_measurement(1, seq));
        if (seq == 4) continue;
        auto command = sample_command(1, seq);
        if (seq == 6) command.force[2] = force;
        log.write(channels::command, command);
      }
    }
    Keeper keeper;
    return scan_log(folder / "run.lcm", {}, keeper).faults;
  };
  EXPECT_EQ(faults(1).n_not_finite, 0);
  EXPECT_EQ(faults(1).n_repeats, 0);
  EXPECT_EQ(faults(std::nan("")).n_not_finite, 1);
  EXPECT_EQ(faults(std::nan("")).first_not_finite, "seq 6, command of leg_3");
}

/// The repeats of a run of 100 samples that stands still from 20 to 39. floor: of sample k.
std::int64_t repeats(const std::function<double(std::int64_t)>& floor,
                     const std::function<bool(std::int64_t)>& lost, bool frame_moves = false) {
  SampleCheck check(sample_info(1, 100));
  for (std::int64_t seq = 0; seq < 100; ++seq) {
    const std::int64_t shown = seq < 20 || seq >= 40 ? seq : 20;
    std::vector<double> values = values_of(sample_measurement(1, shown));
    values[0] = values[1] = floor(shown);
    if (frame_moves) values[9] = static_cast<double>(seq);
    if (!lost(seq)) check.measurement(seq, values.data());
  }
  return check.faults().n_repeats;
}

TEST(SampleCheck, CountsWhatStandsStillWhileTheFloorMoves) {
  const auto moving = [](std::int64_t k) { return 1 + 0.1 * static_cast<double>(k); };
  const auto none = [](std::int64_t) { return false; };
  EXPECT_EQ(repeats(moving, none), 19);
  // A channel that goes on shows that the others only did not change.
  EXPECT_EQ(repeats(moving, none, true), 0);
  // What is behind a gap is not the next one.
  EXPECT_EQ(repeats(moving, [](std::int64_t k) { return k == 30; }), 17);
  // A floor that rests for a while, and one that never moves.
  EXPECT_EQ(repeats([](std::int64_t k) { return k < 20 ? 1.0 : 0.0; }, none), 0);
  EXPECT_EQ(repeats([](std::int64_t) { return 9.81; }, none), 0);
}

}  // namespace
}  // namespace stillframe::report

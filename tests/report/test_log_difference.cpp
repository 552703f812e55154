#include <gtest/gtest.h>

#include <cmath>

#include "core/yaml/input_error.hpp"
#include "report/log/log_difference.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"

namespace stillframe::report {
namespace {

class LogDifferenceTest : public ::testing::Test {
 protected:
  ScratchFolder folder_;

  template <typename Fill>
  std::filesystem::path write(const std::string& name, Fill&& fill) {
    LogWriter log(folder_ / name);
    fill(log);
    return folder_ / name;
  }

  /// A run of ten samples in which one measurement or command is changed before it is written.
  template <typename ChangeMeasurement, typename ChangeCommand>
  std::filesystem::path write_changed(const std::string& name,
                                      ChangeMeasurement&& change_measurement,
                                      ChangeCommand&& change_command) {
    return write(name, [&](LogWriter& w) {
      for (int seq = 0; seq < 10; ++seq) {
        auto measurement = sample_measurement(1, seq);
        auto command = sample_command(1, seq);
        change_measurement(measurement);
        change_command(command);
        w.write(channels::measurement, measurement);
        w.write(channels::command, command);
      }
    });
  }

  std::filesystem::path plain_ = write("plain.lcm", [](LogWriter& w) { write_run(w, 1, 10); });
};

constexpr auto no_change = [](auto&) {};

TEST_F(LogDifferenceTest, SameRunsAreIdenticalWhateverStandsBetween) {
  const auto other = write("other.lcm", [](LogWriter& w) {
    w.write_bytes("CAMERA", {1});
    for (int seq = 0; seq < 10; ++seq) {
      w.write(channels::measurement, sample_measurement(1, seq));
      w.write(channels::measurement, sample_measurement(1, seq));
    }
    for (int seq = 0; seq < 10; ++seq) w.write(channels::command, sample_command(1, seq));
  });
  const LogDifference result = compare_logs(plain_, other);
  EXPECT_TRUE(result.identical) << result.first_difference;
  EXPECT_EQ(result.first_difference, "");
  EXPECT_TRUE(result.same_run_id);
  EXPECT_EQ(result.n_measurements, 10);
  EXPECT_EQ(result.n_commands, 10);
}

TEST_F(LogDifferenceTest, RunIdIsLeftOutAndReported) {
  const auto other = write("other.lcm", [](LogWriter& w) { write_run(w, 2, 10); });
  const LogDifference result = compare_logs(plain_, other);
  EXPECT_TRUE(result.identical) << result.first_difference;
  EXPECT_FALSE(result.same_run_id);
}

TEST_F(LogDifferenceTest, NamesTheFirstBitThatDiffers) {
  const auto changed = write_changed(
      "changed.lcm",
      [](auto& m) {
        if (m.seq >= 6) m.sigma[1] = std::nextafter(m.sigma[1], 100);
      },
      no_change);
  const LogDifference result = compare_logs(plain_, changed);
  EXPECT_FALSE(result.identical);
  EXPECT_EQ(result.first_difference,
            "SF_MEASUREMENT: message 6, seq 6: sigma[1]: 7.2 and 7.200000000000001");
}

TEST_F(LogDifferenceTest, ZerosOfDifferentSignDiffer) {
  const auto zero = [](double value) { return [value](auto& c) { c.force[0] = value; }; };
  const auto a = write_changed("a.lcm", no_change, zero(0.0)),
             b = write_changed("b.lcm", no_change, zero(-0.0));
  EXPECT_EQ(compare_logs(a, b).first_difference,
            "SF_COMMAND: message 0, seq 0: force[0]: 0 and -0");
}

TEST_F(LogDifferenceTest, FindsCommandsOrderAndLength) {
  const auto saturated =
      write_changed("a.lcm", no_change, [](auto& c) { c.saturated = c.seq == 9; });
  EXPECT_EQ(compare_logs(plain_, saturated).first_difference,
            "SF_COMMAND: message 3, seq 3: saturated: 1 and 0");
  const auto swapped = write("b.lcm", [](LogWriter& w) {
    for (const int seq : {0, 1, 3, 2}) w.write(channels::measurement, sample_measurement(1, seq));
  });
  EXPECT_EQ(compare_logs(plain_, swapped).first_difference,
            "SF_MEASUREMENT: message 2, seq 2: seq: 2 and 3");
  const auto shorter = write("c.lcm", [](LogWriter& w) { write_run(w, 1, 9); });
  EXPECT_EQ(compare_logs(plain_, shorter).first_difference,
            "SF_MEASUREMENT: 10 and 9 messages, the shorter is the beginning of the longer");
}

TEST_F(LogDifferenceTest, RefusesLogsWithoutMeasurements) {
  const auto empty = write("empty.lcm", [](LogWriter&) {});
  expect_error<InputError>([&] { compare_logs(plain_, empty); }, "no SF_MEASUREMENT message");
  expect_error<InputError>([&] { compare_logs(folder_ / "none.lcm", plain_); }, "no such LCM log");
}

}  // namespace
}  // namespace stillframe::report

#include <gtest/gtest.h>

#include "core/errors/input_error.hpp"
#include "report/log/run_log.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using std::filesystem::path;

class RunLogTest : public ::testing::Test {
 protected:
  test::ScratchFolder folder_;
  path file_ = folder_ / "run.lcm";

  /// Writes a log by `fill(LogWriter&)` and reads it.
  template <typename Fill>
  RunLog read(Fill&& fill, std::optional<std::int64_t> run_id = std::nullopt) {
    {
      LogWriter log(file_);
      fill(log);
    }
    return read_run_log(file_, run_id);
  }
};

TEST_F(RunLogTest, ReadsEveryNumberToItsPlace) {
  const RunLog log = read([](LogWriter& w) {
    write_run(w, 42, 8);
    stillframe_msgs::timing_t timing{};
    timing.run_id = 42;
    timing.source = "controller";
    timing.n_late = 3;
    w.write(channels::timing, timing);
    timing.source = "plant";
    timing.wall_time_ns = 5'000'000;
    w.write(channels::timing, timing);
  });
  EXPECT_EQ(log.info.run_id, 42);
  EXPECT_EQ(log.info.leg_names, (std::vector<std::string>{"leg_1", "leg_2", "leg_3"}));
  ASSERT_EQ(log.floor_acceleration.rows(), 8);
  ASSERT_EQ(log.floor_acceleration.cols(), 2);
  ASSERT_EQ(log.sigma.cols(), 3);
  for (int k = 0; k < 8; ++k) {
    const auto expected = sample_measurement(42, k);
    EXPECT_EQ(log.seq[static_cast<std::size_t>(k)], k);
    EXPECT_DOUBLE_EQ(log.time_s(k), 1e-3 * k);
    for (int i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_EQ(log.sigma(k, i), expected.sigma[at]);
      EXPECT_EQ(log.applied_force(k, i), expected.applied_force[at]);
      EXPECT_EQ(log.command_force(k, i), sample_command(42, k).force[at]);
      if (i == 2) continue;
      EXPECT_EQ(log.floor_acceleration(k, i), expected.floor_acceleration[at]);
      EXPECT_EQ(log.frame_acceleration(k, i), expected.frame_acceleration[at]);
    }
  }
  EXPECT_EQ(log.n_saturated, 2);
  EXPECT_EQ(log.measurements.n_received, 8);
  EXPECT_EQ(
      log.measurements.n_lost + log.measurements.n_duplicates + log.measurements.n_out_of_order, 0);
  EXPECT_EQ(log.n_damaged + log.unread_bytes, 0);
  // 7 measurements after the first, a command between each two, 1 ms a message.
  EXPECT_NEAR(log.log_duration_s, 14e-3, 1e-12);
  ASSERT_TRUE(log.plant_timing && log.controller_timing);
  EXPECT_EQ(log.plant_timing->wall_time_ns, 5'000'000);
  EXPECT_EQ(log.controller_timing->n_late, 3);
}

TEST_F(RunLogTest, CountsGapsRepeatsAndDisorder) {
  const RunLog log = read([](LogWriter& w) {
    w.write(channels::run_info, sample_info(1, 12));
    for (const int seq : {1, 2, 2, 2, 4, 3, 7, 4, 8}) {
      w.write(channels::measurement, sample_measurement(1, seq));
    }
    for (const int seq : {2, 3, 3, 6}) w.write(channels::command, sample_command(1, seq));
  });
  EXPECT_EQ(log.seq, (std::vector<std::int64_t>{1, 2, 3, 4, 7, 8}));
  EXPECT_EQ(log.sigma(3, 0), sample_measurement(1, 4).sigma[0]);
  EXPECT_EQ(log.measurements.n_duplicates, 3);
  EXPECT_EQ(log.measurements.n_out_of_order, 2);
  ASSERT_EQ(log.measurements.gaps.size(), 3u);
  EXPECT_EQ(log.measurements.gaps[0].first, 0);
  EXPECT_EQ(log.measurements.gaps[0].last, 0);
  EXPECT_EQ(log.measurements.gaps[1].first, 5);
  EXPECT_EQ(log.measurements.gaps[1].last, 6);
  EXPECT_EQ(log.measurements.gaps[2].first, 9);
  EXPECT_EQ(log.measurements.gaps[2].last, 11);
  EXPECT_EQ(log.measurements.n_lost, 6);
  EXPECT_EQ(log.command_seq, (std::vector<std::int64_t>{2, 3, 6}));
  EXPECT_EQ(log.commands.n_duplicates, 1);
  EXPECT_EQ(log.commands.n_lost, 4);  // 4, 5, 7 and 8
}

TEST_F(RunLogTest, IgnoresForeignChannelsAndOtherRuns) {
  const auto fill = [](LogWriter& w) {
    w.write_bytes("CAMERA", {1, 2, 3});
    write_run(w, 1, 3);
    w.write(channels::measurement, sample_measurement(9, 77));
    w.write_bytes("SF_MEASUREMENT_COPY", {1, 2, 3});
  };
  const RunLog log = read(fill);
  EXPECT_EQ(log.measurements.n_received, 3);
  EXPECT_EQ(log.n_damaged, 0);
}

TEST_F(RunLogTest, ChoosesARunByItsNumber) {
  const auto fill = [](LogWriter& w) {
    write_run(w, 1, 3);
    write_run(w, 2, 5);
  };
  EXPECT_EQ(read(fill, 2).measurements.n_received, 5);
  EXPECT_EQ(read(fill, 1).measurements.n_received, 3);
  expect_error<InputError>([&] { read(fill); }, "several runs in one log, name the run_id: 1, 2");
  expect_error<InputError>([&] { read(fill, 3); }, "found none with 3, this log holds 1, 2");
}

TEST_F(RunLogTest, RefusesLogsThatAreNoRun) {
  expect_error<InputError>([&] { read_run_log(folder_ / "none.lcm"); }, "there is no such LCM log");
  expect_error<InputError>([&] { read_run_log(folder_.path()); }, "there is no such LCM log");
  expect_error<InputError>([&] { read([](LogWriter& w) { w.write_bytes("OTHER", {1}); }); },
                           "no message of a stillframe run");
  expect_error<InputError>([&] { read([](LogWriter&) {}); }, "no message of a stillframe run");
  expect_error<InputError>(
      [&] { read([](LogWriter& w) { w.write(channels::measurement, sample_measurement(1, 0)); }); },
      "no SF_RUN_INFO message");
  expect_error<InputError>(
      [&] { read([](LogWriter& w) { w.write(channels::run_info, sample_info(5, 3)); }); },
      "run 5 has a SF_RUN_INFO but no SF_MEASUREMENT");
}

TEST_F(RunLogTest, RefusesMessagesThatContradictEachOther) {
  const auto with = [](auto change) {
    return [change](LogWriter& w) {
      auto info = sample_info(1, 2);
      auto first = sample_measurement(1, 0), second = sample_measurement(1, 1);
      change(info, first, second);
      w.write(channels::run_info, info);
      w.write(channels::measurement, first);
      w.write(channels::measurement, second);
    };
  };
  expect_error<InputError>(
      [&] { read(with([](auto& info, auto&, auto&) { info.format_version = 2; })); },
      "format_version: found 2, this program reads 1");
  expect_error<InputError>(
      [&] { read(with([](auto& info, auto&, auto&) { info.sample_rate_hz = 0; })); },
      "sample_rate_hz");
  // Before any memory is taken by it.
  expect_error<InputError>(
      [&] { read(with([](auto& info, auto&, auto&) { info.sample_rate_hz = 1e9; })); },
      "sample_rate_hz: found 1e+09, but its samples are 0.001 s apart");
  expect_error<InputError>(
      [&] {
        read(with([](auto& info, auto&, auto&) {
          info.n_legs = 4;
          info.leg_names.push_back("leg_4");
        }));
      },
      "sigma: found 3 values at seq 0, run_info says 4");
  expect_error<InputError>([&] { read(with([](auto&, auto&, auto& second) { second.seq = 0; })); },
                           "two different messages with seq 0");
}

TEST_F(RunLogTest, ReadsWhatATruncatedLogStillHolds) {
  {
    LogWriter log(file_);
    write_run(log, 1, 50);
  }
  const auto size = std::filesystem::file_size(file_);
  std::int64_t last = 50;
  // Every place within the last two events, and some further up.
  for (std::uintmax_t cut = 1; cut < 600; cut += cut < 400 ? 1 : 37) {
    std::filesystem::resize_file(file_, size - cut);
    const RunLog log = read_run_log(file_);
    EXPECT_LE(log.measurements.n_received, last);
    EXPECT_EQ(log.measurements.n_received + log.measurements.n_lost, 50);
    EXPECT_EQ(log.seq.back() + 1, log.measurements.n_received);
    last = log.measurements.n_received;
  }
  EXPECT_LT(last, 50);
  std::filesystem::resize_file(file_, size - 600);
  EXPECT_GT(read_run_log(file_).unread_bytes, 0);
}

TEST_F(RunLogTest, ReadsOnBehindADamagedEvent) {
  {
    LogWriter log(file_);
    write_run(log, 1, 50);
  }
  const auto size = std::filesystem::file_size(file_);
  std::FILE* file = std::fopen(file_.c_str(), "r+b");
  ASSERT_NE(file, nullptr);
  std::fseek(file, static_cast<long>(size / 2), SEEK_SET);
  const std::vector<unsigned char> rubbish(100, 0xA5);
  std::fwrite(rubbish.data(), 1, rubbish.size(), file);
  std::fclose(file);
  const RunLog log = read_run_log(file_);
  EXPECT_GT(log.n_damaged, 0);
  EXPECT_GE(log.measurements.n_received, 47);
  EXPECT_EQ(log.seq.back(), 49);
  EXPECT_EQ(log.measurements.n_received + log.measurements.n_lost, 50);
}

TEST_F(RunLogTest, CountsPayloadsThatAreNoMessage) {
  const RunLog log = read([](LogWriter& w) {
    write_run(w, 1, 3);
    w.write_bytes(channels::measurement, {1, 2, 3});
    w.write_bytes(channels::timing, std::vector<char>(200, 0));
  });
  EXPECT_EQ(log.n_damaged, 2);
  EXPECT_EQ(log.measurements.n_received, 3);
}

}  // namespace
}  // namespace stillframe::report

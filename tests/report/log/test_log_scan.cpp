// What a scan makes of a log: samples in order, in blocks, with their commands, and all counted.
#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "core/errors/input_error.hpp"
#include "report/log/run_log.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/log/log_bytes.hpp"
#include "tests/report/log/run_fixture.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Sizes = std::vector<Eigen::Index>;
using Numbers = std::vector<std::int64_t>;

class LogScanTest : public ::testing::Test {
 protected:
  test::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "run.lcm";
  Keeper kept_;

  template <typename Fill>
  LogScan scan(Fill&& fill, const ScanSettings& settings = {}) {
    {
      LogWriter log(file_);
      fill(log);
    }
    kept_ = Keeper();
    return scan_log(file_, settings, kept_);
  }

  Numbers received() const {
    Numbers seq;
    for (const auto& [number, sample] : kept_.samples_by_seq) seq.push_back(number);
    return seq;
  }
};

/// Measurements in the order given.
auto measurements(const Numbers& order, std::int64_t announced = 0) {
  return [=](LogWriter& w) {
    w.write(channels::run_info, sample_info(1, announced));
    for (const std::int64_t seq : order) {
      w.write(channels::measurement, sample_measurement(1, seq));
    }
  };
}

TEST_F(LogScanTest, EveryNumberComesToItsPlace) {
  const LogScan s = scan([](LogWriter& w) {
    std::mt19937_64 random(3);
    write_full_run(w, 42, 1000, random);
  });
  EXPECT_TRUE(kept_.is_orderly);
  EXPECT_EQ(kept_.samples_by_seq.size(), 1000u);
  // What the log holds, by LCM's own reader and decoders.
  std::int64_t n_commands = 0, n_saturated = 0;
  for (const LoggedEvent& event : events_by_lcm(file_)) {
    const int size = static_cast<int>(event.payload.size());
    if (event.channel == channels::measurement) {
      stillframe_msgs::measurement_t m;
      ASSERT_EQ(m.decode(event.payload.data(), 0, size), size);
      const Keeper::Sample& sample = kept_.samples_by_seq.at(m.seq);
      EXPECT_EQ(sample.time_s, static_cast<double>(m.time_ns) / 1e9);
      EXPECT_EQ(sample.floor, bits(m.floor_acceleration));
      EXPECT_EQ(sample.sigma, bits(m.sigma));
      EXPECT_EQ(sample.applied, bits(m.applied_force));
      EXPECT_EQ(sample.frame, bits(m.frame_acceleration));
    } else if (event.channel == channels::command) {
      stillframe_msgs::command_t c;
      ASSERT_EQ(c.decode(event.payload.data(), 0, size), size);
      EXPECT_EQ(kept_.samples_by_seq.at(c.seq).command, bits(c.force));
      ++n_commands;
      n_saturated += c.saturated;
    }
  }
  EXPECT_EQ(s.commands.n_received, n_commands);
  EXPECT_EQ(s.n_saturated, n_saturated);
  EXPECT_EQ(s.measurements.n_lost + s.commands.n_lost + s.n_too_late, 0);
  EXPECT_EQ(s.n_damaged + s.n_undecodable + s.unread_bytes + s.n_other_version, 0);
  EXPECT_EQ(s.foreign, (std::map<std::string, std::int64_t>{{"CAMERA", 20}}));
  Numbers periods;
  for (std::int64_t seq = 49; seq < 1000; seq += 50) {
    periods.insert(periods.end(), {seq - 1, seq});
  }
  EXPECT_EQ(kept_.periods, periods);
  EXPECT_EQ(s.first_us, 1'005'000);  // a millisecond a message, the fifth is a measurement
  ASSERT_TRUE(s.last_status && s.plant_timing);
  EXPECT_EQ(s.last_status->n_periods, 999);
  EXPECT_FALSE(s.controller_timing);
}

TEST_F(LogScanTest, BlocksAreFullOrEndAtAGap) {
  ScanSettings settings;
  settings.block_samples = 4;
  scan(measurements({0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 20}), settings);
  EXPECT_EQ(kept_.block_begins, (Numbers{0, 4, 7, 11, 20}));
  EXPECT_EQ(kept_.block_sizes, (Sizes{4, 2, 4, 1, 1}));
  EXPECT_TRUE(kept_.is_orderly);
}

TEST_F(LogScanTest, LateMessagesFindTheirPlaceWithinTheWindow) {
  ScanSettings settings;
  settings.reorder_samples = 4;
  // 1 is 3 older than the newest and comes in time; 2 is 4 older than 6 and does not.
  const LogScan s = scan(measurements({0, 4, 1, 5, 3, 6, 2, 7}), settings);
  EXPECT_EQ(received(), (Numbers{0, 1, 3, 4, 5, 6, 7}));
  EXPECT_EQ(s.n_too_late, 1);
  EXPECT_EQ(s.measurements.n_out_of_order, 3);
  EXPECT_EQ(s.measurements.n_received, 7);
  EXPECT_EQ(s.measurements.n_lost, 1);
  ASSERT_EQ(s.measurements.gaps.size(), 1u);
  EXPECT_EQ(s.measurements.gaps[0].first, 2);
  // With room for it nothing is late.
  settings.reorder_samples = 5;
  EXPECT_EQ(scan(measurements({0, 4, 1, 5, 3, 6, 2, 7}), settings).n_too_late, 0);
  EXPECT_EQ(received().size(), 8u);
}

TEST_F(LogScanTest, TheFirstMessageNeedNotBeTheOldest) {
  const LogScan s = scan(measurements({12, 10, 11, 13}));
  EXPECT_EQ(received(), (Numbers{10, 11, 12, 13}));
  EXPECT_EQ(s.measurements.n_lost, 10);
}

TEST_F(LogScanTest, CommandsStandInTheRowThatTheyAnswer) {
  const LogScan s = scan([](LogWriter& w) {
    w.write(channels::run_info, sample_info(1, 6));
    for (const int seq : {0, 1, 2, 4}) {
      w.write(channels::measurement, sample_measurement(1, seq));
      if (seq == 2) w.write(channels::command, sample_command(1, 0));  // two samples late
    }
    for (const int seq : {3, 2, 2}) w.write(channels::command, sample_command(1, seq));
  });
  EXPECT_EQ(kept_.samples_by_seq.at(0).command, bits(sample_command(1, 0).force));
  EXPECT_EQ(kept_.samples_by_seq.at(2).command, bits(sample_command(1, 2).force));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kept_.samples_by_seq.at(1).command, bits({nan, nan, nan}));
  EXPECT_FALSE(kept_.samples_by_seq.contains(3));  // an answer to a lost measurement
  EXPECT_EQ(s.commands.n_received, 3);
  EXPECT_EQ(s.commands.n_duplicates, 1);
  EXPECT_EQ(s.commands.n_lost, 2);  // 1 and 4 have no answer
  EXPECT_EQ(s.n_saturated, 1);
  // Commands without a measurement are in the log that is read whole.
  EXPECT_EQ(read_run_log(file_).command_seq, (Numbers{0, 2, 3}));
}

// One that lets go of its forces says so behind the end of a run, where it has nothing to answer.
TEST_F(LogScanTest, BehindTheLastMeasurementNothingIsUnanswered) {
  const LogScan s = scan([](LogWriter& w) {
    w.write(channels::run_info, sample_info(1, 6));
    for (int seq = 0; seq < 6; ++seq) w.write(channels::measurement, sample_measurement(1, seq));
    for (const int seq : {0, 2, 3, 15}) w.write(channels::command, sample_command(1, seq));
  });
  EXPECT_EQ(s.commands.n_received, 4);
  EXPECT_EQ(s.commands.n_lost, 3) << "1, 4 and 5";
  ASSERT_EQ(s.commands.gaps.size(), 2u);
  EXPECT_EQ(s.commands.gaps.back().first, 4);
  EXPECT_EQ(s.commands.gaps.back().last, 5);
}

TEST_F(LogScanTest, TheWholeLogIsWhatTheBlocksSay) {
  Numbers order(20'000);
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [](std::int64_t seq) { return seq % 977 == 5; });
  const LogScan s = scan(measurements(order, 20'100));
  const RunLog log = read_run_log(file_);
  EXPECT_EQ(log.seq, order);
  EXPECT_EQ(log.seq, received());
  EXPECT_EQ(log.measurements.n_lost, s.measurements.n_lost);
  EXPECT_EQ(log.measurements.n_lost, 20'100 - static_cast<std::int64_t>(order.size()));
  EXPECT_EQ(log.measurements.gaps.size(), 22u);
  EXPECT_EQ(s.measurements.n_after, 100);
  EXPECT_EQ(s.measurements.n_spanned(), 19'999);
  for (std::size_t k = 0; k < order.size(); k += 97) {
    const auto row = static_cast<Eigen::Index>(k);
    EXPECT_EQ(row_bits(log.frame_acceleration.row(row)), kept_.samples_by_seq.at(order[k]).frame);
  }
}

TEST_F(LogScanTest, ALogMayBeginBeforeOrAfterTheRun) {
  // Begun late: samples first, and the run_info that the controller's restart asked for.
  LogScan s = scan([](LogWriter& w) {
    for (int seq = 5000; seq < 5003; ++seq) {
      w.write(channels::measurement, sample_measurement(1, seq));
    }
    w.write(channels::run_info, sample_info(1, 0));
    w.write(channels::measurement, sample_measurement(1, 5003));
  });
  EXPECT_EQ(received(), (Numbers{5000, 5001, 5002, 5003}));
  EXPECT_EQ(s.measurements.n_lost, 5000);
  // Begun before, with the end of another run in it, and a run that never had a sample.
  s = scan([](LogWriter& w) {
    w.write(channels::measurement, sample_measurement(8, 99));
    w.write(channels::run_info, sample_info(3, 10));
    write_run(w, 1, 3);
  });
  EXPECT_EQ(s.info.run_id, 1);
  EXPECT_EQ(s.measurements.n_received, 3);
}

TEST_F(LogScanTest, PartsOfASplitLogAreReadTogether) {
  // Each part begins to number its events anew.
  const auto part = [this](const char* name, const auto& fill) {
    {
      LogWriter writer(folder_ / name);
      fill(writer);
    }
    return bytes_of(folder_ / name);
  };
  const auto samples = [](std::int64_t first) {
    return [first](LogWriter& w) {
      w.write(channels::measurement, sample_measurement(1, first));
      w.write(channels::measurement, sample_measurement(1, first + 1));
    };
  };
  const std::string whole =
      part("a", [](LogWriter& w) { w.write(channels::run_info, sample_info(1, 4)); }) +
      part("b", samples(0)) + part("c", samples(2));
  write_bytes_to(file_, whole);
  Keeper kept;
  const LogScan s = scan_log(file_, {}, kept);
  EXPECT_EQ(s.measurements.n_received, 4);
  EXPECT_EQ(s.n_damaged, 0);
  expect_error<InputError>([&] { scan_log(folder_ / "b", {}, kept); },
                           "no SF_RUN_INFO message, so the others cannot be read; of a log that "
                           "was split, put the parts together first (cat LOG.* > whole.lcm)");
}

TEST_F(LogScanTest, CopiesOfRunInfoOutvoteADamagedOne) {
  for (const int bad : {0, 1, 2}) {
    const LogScan s = scan([&](LogWriter& w) {
      for (int copy = 0; copy < 3; ++copy) {
        auto info = sample_info(1, 2);
        if (copy == bad) info.sample_rate_hz = 1100;
        w.write(channels::run_info, info);
      }
      for (const int seq : {0, 1}) w.write(channels::measurement, sample_measurement(1, seq));
    });
    EXPECT_EQ(s.info.sample_rate_hz, 1000);
  }
  // One against one: the one that can be true.
  const LogScan s = scan([&](LogWriter& w) {
    auto info = sample_info(1, 2);
    info.format_version = 77;
    w.write(channels::run_info, info);
    measurements({0, 1})(w);
  });
  EXPECT_EQ(s.info.format_version, 1);
}

TEST_F(LogScanTest, TextsAreUtf8) {
  const LogScan s = scan([](LogWriter& w) {
    auto info = sample_info(1, 1);
    info.scene_text = "\xC3\xA9\xFF\xE2\x82\xAC\xC3";
    info.leg_names[1] = "leg\x80";
    w.write(channels::run_info, info);
    w.write(channels::measurement, sample_measurement(1, 0));
  });
  EXPECT_EQ(s.info.scene_text, "\xC3\xA9\xEF\xBF\xBD\xE2\x82\xAC\xEF\xBF\xBD");
  EXPECT_EQ(kept_.info.leg_names[1], "leg\xEF\xBF\xBD");
}

TEST_F(LogScanTest, MessagesOfAnotherVersionAreCountedAsSuch) {
  const auto other = [](std::vector<char> bytes) {
    bytes[3] = static_cast<char>(bytes[3] + 1);
    return bytes;
  };
  const auto encoded = [](const auto& message) {
    std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
  };
  const LogScan s = scan([&](LogWriter& w) {
    write_run(w, 1, 3);
    w.write_bytes(channels::measurement, other(encoded(sample_measurement(1, 3))));
    w.write_bytes(channels::status, other(encoded(stillframe_msgs::controller_status_t{})));
    w.write_bytes(channels::command, {1, 2, 3});
  });
  EXPECT_EQ(s.n_undecodable, 3);
  EXPECT_EQ(s.n_other_version, 2);
  // A log of another version alone says why it is refused.
  expect_error<InputError>(
      [&] {
        scan([&](LogWriter& w) {
          w.write_bytes(channels::run_info, other(encoded(sample_info(1, 3))));
          w.write_bytes(channels::measurement, other(encoded(sample_measurement(1, 0))));
        });
      },
      "no message of a stillframe run in this log; 2 messages on its channels are of other "
      "versions of their types");
}

TEST_F(LogScanTest, ForeignChannelsAreListedUpToAHundred) {
  const LogScan s = scan([](LogWriter& w) {
    write_run(w, 1, 2);
    w.write_bytes(channels::logger_check, {});
    for (int i = 0; i < 130; ++i) w.write_bytes("OTHER_" + std::to_string(i), {1});
    w.write_bytes("OTHER_3", {1});
    w.write_bytes("BAD\x01NAME", {1});
  });
  EXPECT_EQ(s.foreign.size(), 101u);
  EXPECT_EQ(s.foreign.at("OTHER_3"), 2);
  EXPECT_EQ(s.foreign.at(""), 30);
  EXPECT_EQ(s.n_damaged, 1);  // no such name can be sent
}

TEST_F(LogScanTest, AWrongSeqNeverTakesAnothersPlace) {
  // That of sample 5 is damaged: ahead within the window, far ahead, and back.
  for (const std::int64_t wrong : {7LL, 1LL << 40, 2LL, 4LL}) {
    const LogScan s = scan([&](LogWriter& w) {
      w.write(channels::run_info, sample_info(1, 40));
      for (int seq = 0; seq < 40; ++seq) {
        auto m = sample_measurement(1, seq);
        if (seq == 5) m.seq = wrong;
        w.write(channels::measurement, m);
      }
    });
    EXPECT_EQ(s.measurements.n_received, 39);
    EXPECT_EQ(s.measurements.n_lost, 1);
    EXPECT_EQ(s.n_undecodable, 1);
    EXPECT_EQ(kept_.samples_by_seq.at(7).sigma, bits(sample_measurement(1, 7).sigma));
  }
}

TEST_F(LogScanTest, ASendersOwnClockIsFollowed) {
  // Its time begins elsewhere, drifts by 50 ppm, and is set once by an hour.
  const LogScan s = scan([](LogWriter& w) {
    w.write(channels::run_info, sample_info(1, 30'000));
    for (int seq = 0; seq < 30'000; ++seq) {
      auto m = sample_measurement(1, seq);
      m.time_ns = 1'700'000'000'000'000'000 + seq * 1'000'050LL;
      if (seq >= 20'000) m.time_ns += 3'600'000'000'000;
      w.write(channels::measurement, m);
    }
  });
  EXPECT_EQ(s.measurements.n_received, 30'000);
  EXPECT_EQ(s.n_undecodable, 0);
  // A run that is over before its clock could be learned.
  EXPECT_EQ(scan([](LogWriter& w) {
              w.write(channels::run_info, sample_info(1, 5));
              for (int seq = 0; seq < 5; ++seq) {
                auto m = sample_measurement(1, seq);
                m.time_ns += 5'000'000'000;
                w.write(channels::measurement, m);
              }
            }).measurements.n_received,
            5);
}

/// Writes measurements at times by the logger's clock, us.
auto logged_at(const std::vector<std::int64_t>& times_us) {
  return [=](const std::filesystem::path& file) {
    lcm_eventlog_t* log = lcm_eventlog_create(file.c_str(), "w");
    const auto write = [log](std::string channel, const auto& message, std::int64_t time_us) {
      std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
      message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      lcm_eventlog_event_t event{.eventnum = 0,
                                 .timestamp = time_us,
                                 .channellen = static_cast<int32_t>(channel.size()),
                                 .datalen = static_cast<int32_t>(bytes.size()),
                                 .channel = channel.data(),
                                 .data = bytes.data()};
      lcm_eventlog_write_event(log, &event);
    };
    // The pause before the first sample is none of the run's.
    write(channels::run_info, sample_info(1, 0), times_us[0] - 60'000'000);
    for (std::size_t k = 0; k < times_us.size(); ++k) {
      write(channels::measurement, sample_measurement(1, static_cast<std::int64_t>(k)),
            times_us[k]);
    }
    lcm_eventlog_destroy(log);
  };
}

TEST_F(LogScanTest, StepsOfTheLoggersClockAreTakenOut) {
  struct Case {
    std::vector<std::int64_t> times_us;
    std::int64_t n_steps;
    double largest_s, duration_s;
  };
  constexpr std::int64_t hour = 3'600'000'000, t = 1'700'000'000'000'000;
  const std::vector<Case> cases{
      {{t, t + 1000, t + 2000, t + 3000}, 0, 0, 3e-3},
      // An hour ahead, an hour back, both; the millisecond of each step is lost with it.
      {{t, t + 1000, t + hour, t + hour + 1000, t + hour + 2000}, 1, 3600 - 1e-3, 3e-3},
      {{t, t + 1000, t - hour, t - hour + 1000, t - hour + 2000}, 1, -3600 - 1e-3, 3e-3},
      {{t, t + hour, t + hour + 1000, t + 1000, t + 2000, t + 3000}, 2, 3600, 3e-3},
      // A minute is no step yet, a millisecond back is one.
      {{t, t + 60'000'000, t + 60'001'000}, 0, 0, 60.001},
      {{t, t + 5000, t + 4000, t + 4500}, 1, -1e-3, 5.5e-3},
      // Two damaged times that lie near each other, with sound ones between, are none.
      {{t, t + 1000, t + hour, t + 3000, t + hour + 2000, t + 5000}, 0, 0, 5e-3},
      // One damaged time is none.
      {{t, t + 1000, t ^ (1LL << 45), t + 3000, t + 4000}, 0, 0, 4e-3},
  };
  for (const Case& c : cases) {
    logged_at(c.times_us)(file_);
    Keeper kept;
    const LogScan s = scan_log(file_, {}, kept);
    EXPECT_EQ(s.n_clock_steps, c.n_steps);
    // Times of 1.7e9 s in double have 2.4e-7 s; a step is their difference.
    EXPECT_NEAR(s.largest_clock_step_s, c.largest_s, 1e-6);
    EXPECT_NEAR(s.log_duration_s, c.duration_s, 1e-12);
  }
}

TEST_F(LogScanTest, ProgressRunsFromNothingToAll) {
  std::vector<double> shares;
  ScanSettings settings;
  settings.progress = [&](double share) { shares.push_back(share); };
  scan(
      [](LogWriter& w) {
        write_run(w, 1, 10);
        for (int i = 0; i < 20; ++i) w.write_bytes("FILL", std::vector<char>(1'000'000, 'f'));
      },
      settings);
  ASSERT_GE(shares.size(), 4u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
}

TEST_F(LogScanTest, ContradictionsAreRefusedAndAFewOfThemAreDamage) {
  const auto with_wrong = [](int n_samples, auto spoil) {
    return [=](LogWriter& w) {
      w.write(channels::run_info, sample_info(1, n_samples));
      for (int seq = 0; seq < n_samples; ++seq) {
        auto m = sample_measurement(1, seq);
        spoil(m);
        w.write(channels::measurement, m);
      }
    };
  };
  const auto third_leg = [](auto& m) {
    m.n_legs = 4;
    m.sigma.push_back(0), m.applied_force.push_back(0);
  };
  const auto one = [=](auto& m) {
    if (m.seq == 2) third_leg(m);
  };
  expect_error<InputError>([&] { scan(with_wrong(9, one)); },
                           "sigma: found 4 values at seq 2, run_info says 3");
  const LogScan s = scan(with_wrong(50, one));
  EXPECT_EQ(s.n_undecodable, 1);
  EXPECT_EQ(s.measurements.n_lost, 1);
}

TEST_F(LogScanTest, SettingsMustBePositive) {
  ScanSettings settings;
  settings.block_samples = 0;
  EXPECT_THROW(scan(measurements({0}), settings), std::invalid_argument);
  settings.block_samples = 1;
  settings.reorder_samples = 0;
  EXPECT_THROW(scan(measurements({0}), settings), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::report

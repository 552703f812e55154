// A plant that was killed and came back in the same run: what it measures is read by itself.
#include <gtest/gtest.h>

#include "core/errors/input_error.hpp"
#include "report/log/run_log.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/log/run_fixture.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Numbers = std::vector<std::int64_t>;

constexpr std::int64_t run_id = 7, first = 1001, second = 1002;

class PlantPartsTest : public ::testing::Test {
 protected:
  test::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "run.lcm";
  Keeper kept_;
  std::unique_ptr<LogWriter> log_ = std::make_unique<LogWriter>(file_);

  LogScan scan(std::optional<int> plant = {}) {
    log_.reset();
    kept_ = Keeper();
    ScanSettings settings;
    settings.plant = plant;
    return scan_log(file_, settings, kept_);
  }

  void describe(std::int64_t plant, const std::string& scene = "sample",
                const std::string& mode = "wall_clock") {
    auto info = sample_info(run_id, 0);
    info.plant_instance = plant;
    info.scene_name = scene;
    info.mode = mode;
    log_->write(channels::run_info, info);
  }

  /// Its first floor input is the plant's number, so that a sample says whose it is.
  void measure(std::int64_t plant, std::int64_t seq) {
    auto message = sample_measurement(run_id, seq);
    message.plant_instance = plant;
    message.floor_acceleration[0] = static_cast<double>(plant);
    log_->write(channels::measurement, message);
  }

  void answer(std::int64_t plant, std::int64_t seq) {
    auto message = sample_command(run_id, seq);
    message.plant_instance = plant;
    message.force[0] = static_cast<double>(plant);
    log_->write(channels::command, message);
  }

  void measure(std::int64_t plant, std::int64_t begin, std::int64_t end) {
    for (std::int64_t seq = begin; seq < end; ++seq) {
      measure(plant, seq);
      answer(plant, seq);
    }
  }

  void say(std::int64_t plant, std::int64_t n_periods) {
    stillframe_msgs::controller_status_t status{};
    status.run_id = run_id;
    status.plant_instance = plant;
    status.n_periods = n_periods;
    log_->write(channels::status, status);
  }

  void note(std::int64_t period) {
    stillframe_msgs::loop_records_t records{};
    records.run_id = run_id;
    records.n_records = 1;
    records.records.resize(1);
    records.records[0].period = period;
    records.records[0].n_legs = 3;
    records.records[0].sigma = records.records[0].applied = records.records[0].force = {1, 2, 3};
    log_->write(channels::loop, records);
  }

  void count(const std::string& source, std::int64_t n_periods) {
    stillframe_msgs::timing_t timing{};
    timing.run_id = run_id;
    timing.source = source;
    timing.n_periods = n_periods;
    log_->write(channels::timing, timing);
  }

  /// The plants whose samples, and whose commands, were handed out.
  std::pair<Numbers, Numbers> owners() const {
    std::set<std::int64_t> measured, answered;
    for (const auto& [seq, sample] : kept_.samples_by_seq) {
      measured.insert(static_cast<std::int64_t>(std::bit_cast<double>(sample.floor[0])));
      const double force = std::bit_cast<double>(sample.command[0]);
      if (force == force) answered.insert(static_cast<std::int64_t>(force));
    }
    return {{measured.begin(), measured.end()}, {answered.begin(), answered.end()}};
  }
};

Numbers sizes(const LogScan& scan) {
  Numbers found;
  for (const PlantPart& plant : scan.plants) found.push_back(plant.n_samples);
  return found;
}

class KilledAndBack : public PlantPartsTest {
 protected:
  KilledAndBack() {
    describe(first, "before");
    say(first, 0);
    measure(first, 0, 300);
    note(299);
    say(first, 300);
    // The controller notices, and says so until it follows the plant that came back.
    note(340);
    count("controller", 341);
    describe(second, "after");
    say(second, 0);
    note(0);
    measure(second, 0, 100);
    answer(first, 99);  // that was on its way for long
    measure(second, 100, 200);
    note(199);
    say(second, 200);
    count("plant", 200);
    count("controller", 541);
  }
};

TEST_F(KilledAndBack, TheLastOnesPartIsReadAndNothingOfTheOthers) {
  const LogScan s = scan();
  EXPECT_TRUE(kept_.is_orderly);
  EXPECT_EQ(owners(), std::pair(Numbers{second}, Numbers{second}));
  EXPECT_EQ(s.measurements.n_received, 200);
  EXPECT_EQ(s.commands.n_received, 200);
  EXPECT_EQ(s.measurements.n_lost + s.measurements.n_duplicates + s.n_undecodable, 0);
  EXPECT_EQ(s.info.scene_name, "after");
  EXPECT_EQ(kept_.info.plant_instance, second);
  EXPECT_EQ(kept_.periods, (Numbers{0, 199}));
  ASSERT_TRUE(s.last_status && s.plant_timing);
  EXPECT_EQ(s.last_status->n_periods, 200);
  EXPECT_FALSE(s.controller_timing);  // it counts over both
  // By the logger a millisecond a message: 199 measurements with a command each, and one more.
  EXPECT_NEAR(s.log_duration_s, 0.399, 1e-12);
}

TEST_F(KilledAndBack, TheOthersAreSaidAndCanBeChosen) {
  EXPECT_EQ(plants_in_words(scan()),
            "run 7 was measured by 2 plants: plant 1 300 samples, plant 2 200 samples; those of "
            "plant 2 are read and no others (--plant chooses)");
  const LogScan s = scan(1);
  EXPECT_EQ(sizes(s), (Numbers{300, 200}));
  EXPECT_EQ(owners(), std::pair(Numbers{first}, Numbers{first}));
  EXPECT_EQ(s.measurements.n_received, 300);
  EXPECT_EQ(s.info.scene_name, "before");
  EXPECT_EQ(kept_.periods, (Numbers{299, 340}));
  EXPECT_EQ(s.last_status->n_periods, 300);
  EXPECT_FALSE(s.controller_timing);
  EXPECT_FALSE(s.plant_timing);
  EXPECT_NE(plants_in_words(s).find("those of plant 1 are read"), std::string::npos);
  expect_error<InputError>([&] { scan(3); }, "plant: found 3, run 7 has 2 plants, counted from 1");
  expect_error<InputError>([&] { scan(0); }, "plant: found 0");
}

TEST_F(KilledAndBack, AWholeLogIsReadAsTheScanDoes) {
  scan();
  const RunLog log = read_run_log(file_);
  EXPECT_EQ(log.seq.size(), 200u);
  EXPECT_EQ(log.floor_acceleration.col(0), Eigen::VectorXd::Constant(200, second));
  EXPECT_EQ(log.command_force.col(0), Eigen::VectorXd::Constant(200, second));
}

/// A log that was begun after the first plant, of which commands were still under way.
TEST_F(PlantPartsTest, CommandsForAnotherPlantAreNotOfThisOne) {
  describe(second);
  answer(first, 10);
  measure(second, 0, 10);
  for (int seq = 10; seq < 50; ++seq) measure(second, seq);
  const LogScan s = scan();
  EXPECT_EQ(owners(), std::pair(Numbers{second}, Numbers{second}));
  EXPECT_EQ(s.commands.n_received, 10);
  EXPECT_EQ(plants_in_words(s), "");
}

/// A second plant of a number that is there already goes again: the first one was not killed.
TEST_F(PlantPartsTest, ThePlantThatStayedIsTheLast) {
  describe(first);
  measure(first, 0, 100);
  describe(second);
  for (int seq = 0; seq < 3; ++seq) measure(second, seq), measure(first, 100 + seq);
  measure(first, 103, 200);
  const LogScan s = scan();
  EXPECT_EQ(sizes(s), (Numbers{3, 200}));
  EXPECT_EQ(owners().first, Numbers{first});
  EXPECT_EQ(s.measurements.n_lost, 0);
}

/// Damage makes numbers that no plant has, at the end of a log too.
TEST_F(PlantPartsTest, AFewMessagesMakeNoPlant) {
  describe(first);
  measure(first, 0, 100);
  for (int seq = 100; seq < 115; ++seq) measure(second, seq);
  const LogScan s = scan();
  EXPECT_EQ(sizes(s), Numbers{100});
  EXPECT_EQ(owners().first, Numbers{first});
  EXPECT_EQ(plants_in_words(s), "");
}

/// What is not described cannot be read by what another plant said, even if it came last.
TEST_F(PlantPartsTest, APlantWithoutDescriptionIsNotReadByThatOfAnother) {
  describe(first);
  measure(first, 0, 100);
  measure(second, 0, 50);
  const LogScan s = scan();
  EXPECT_EQ(owners().first, Numbers{first});
  EXPECT_NE(plants_in_words(s).find("plant 2 50 samples without SF_RUN_INFO; those of plant 1"),
            std::string::npos);
  expect_error<InputError>([&] { scan(2); }, "plant 2 of run 7 has no SF_RUN_INFO message");
}

/// One that never came to measure has said nothing of the run, however often.
TEST_F(PlantPartsTest, TheDescriptionIsThatOfThePlantThatMeasured) {
  for (int i = 0; i < 5; ++i) describe(first, "before");
  describe(second, "after");
  measure(second, 0, 50);
  EXPECT_EQ(scan().info.scene_name, "after");
}

/// A run whose only description is damaged just where it names its plant is read.
TEST_F(PlantPartsTest, ADescriptionWhoseNumberIsDamagedServesAnOnlyPlant) {
  describe(first ^ (1 << 20));
  measure(first, 0, 50);
  EXPECT_EQ(scan().measurements.n_received, 50);
}

TEST_F(PlantPartsTest, ARepeatedMeasurementIsOneSample) {
  describe(first);
  for (int seq = 0; seq < 40; ++seq) measure(first, seq), measure(first, seq);
  describe(second);
  measure(second, 0, 20);
  EXPECT_EQ(sizes(scan()), (Numbers{40, 20}));
}

/// Runs in one process have no plant: zeros.
TEST_F(PlantPartsTest, ARunWithoutPlantsIsReadWhole) {
  describe(0, "sample", "single_process");
  measure(0, 0, 50);
  const LogScan s = scan(1);
  EXPECT_TRUE(s.plants.empty());
  EXPECT_EQ(owners(), std::pair(Numbers{0}, Numbers{0}));
  EXPECT_EQ(s.commands.n_received, 50);
  expect_error<InputError>([&] { scan(2); }, "plant: found 2, run 7 has 1 plant");
}

}  // namespace
}  // namespace stillframe::report

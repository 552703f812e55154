#include <gtest/gtest.h>

#include <random>

#include "core/errors/input_error.hpp"
#include "report/analysis/log_analyser.hpp"
#include "report/analysis/summaries.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/report/toy_frame.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rate = 500;

/// A log of the toy frame in closed loop on a floor of white noise. The floor accelerations come
/// once as inputs and once as monitors, as in a scene.
class ToyLog : public ::testing::Test {
 protected:
  ToyLog() {
    std::normal_distribution<double> normal;
    const MatrixXd w = MatrixXd::NullaryExpr(20000, 3, [&] { return 1e-3 * normal(random_); });
    record_ = toy::simulate(loop_, w, VectorXd::Zero(loop_.A.rows()));
  }

  stillframe_msgs::run_info_t info() const {
    auto info = sample_info(5, record_.inputs.rows());
    info.sample_rate_hz = rate;
    info.n_floor = 3;
    info.floor_names = {"leg_1", "leg_2", "leg_3"};
    info.n_frame = 6;
    info.frame_names = {"a", "b", "c", "floor_x", "floor_y", "floor_z"};
    return info;
  }
  stillframe_msgs::measurement_t measurement(Index k) const {
    auto message = sample_measurement(5, k);
    message.n_floor = 3;
    message.n_frame = 6;
    message.time_ns = std::llround(1e9 * static_cast<double>(k) / rate);
    message.floor_acceleration.assign(3, 0);
    message.frame_acceleration.assign(6, 0);
    for (Index i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      message.floor_acceleration[at] = message.frame_acceleration[at + 3] = record_.inputs(k, i);
      message.frame_acceleration[at] = record_.outputs(k, i);
    }
    message.frame_acceleration[5] *= floor_z_;
    return message;
  }
  std::filesystem::path write(const std::function<bool(Index)>& lost) const {
    LogWriter log(folder_ / "run.lcm");
    log.write(channels::run_info, info());
    for (Index k = 0; k < record_.inputs.rows(); ++k) {
      if (lost(k)) continue;
      log.write(channels::measurement, measurement(k));
      log.write(channels::command, sample_command(5, k));
    }
    return folder_ / "run.lcm";
  }
  AnalysisPlan plan() const {
    return {.axes = {{"x", "floor_x", "a"}, {"y", "floor_y", "b"}, {"z", "floor_z", "c"}},
            .n_outputs = 3,
            .multisine = {},
            .frequencies_hz = {1, 2, 4, 7, 10, 16, 25, 40, 80},
            .segment_s = 16};
  }
  /// The same with the loop's model: its outputs once as outputs and once as frames of the axes.
  AnalysisPlan plan_with_model(const SampledLoop& loop) const {
    AnalysisPlan what = plan();
    RunModel model{.loop = loop, .matrix = {}, .axes = {}};
    model.loop.C = loop.C.replicate(2, 1);
    model.loop.D = loop.D.replicate(2, 1);
    for (const double f : what.frequencies_hz) {
      model.matrix.push_back(transfer(loop, 2 * toy::pi * f));
    }
    model.axes = model.matrix;
    model.floors = MatrixXd::Identity(3, 3);
    what.model = std::move(model);
    return what;
  }
  LogAnalysis analyse(const std::filesystem::path& path, const AnalysisPlan& what) const {
    return analyse_log(path, {}, [&](const auto&) { return what; });
  }

  test::ScratchFolder folder_;
  std::mt19937_64 random_{3};
  toy::Frame frame_;
  SampledPlant plant_ = sample_and_hold(frame_.plant(), toy::sampled_at(1 / rate, 1));
  SampledLoop loop_ =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, 1 / rate));
  toy::Record record_;
  double floor_z_ = 1;  ///< the channel's factor
};

TEST_F(ToyLog, TellsEverythingInOnePass) {
  const LogAnalysis log = analyse(write([](Index) { return false; }), plan());
  EXPECT_EQ(log.scan.measurements.n_received, 20001);
  ASSERT_EQ(log.axes.size(), 3u);
  ASSERT_EQ(log.legs.size(), 3u);
  // As the whole signals say.
  const SignalAnalysis floor = analyse_signal(record_.inputs.col(1), rate);
  EXPECT_EQ(log.axes[1].floor.density.density, floor.density.density);
  EXPECT_EQ(log.axes[1].floor.levels, floor.levels);
  EXPECT_EQ(log.axes[2].frame.peak, record_.outputs.col(2).cwiseAbs().maxCoeff());
  // Both ways to the same response, within what a parabola leaves (test_local_polynomial.cpp).
  for (const auto* identified : {&log.matrix, &log.axis_matrix}) {
    ASSERT_TRUE(identified->has_value());
    ASSERT_TRUE((*identified)->response.has_value()) << (*identified)->missing;
    const FrequencyResponse& response = *(*identified)->response;
    for (std::size_t l = 0; l < response.T.size(); ++l) {
      const auto exact = transfer(loop_, 2 * toy::pi * response.frequencies_hz[l]);
      EXPECT_LT((response.T[l] - exact).norm(), 1.5e-2 * exact.norm()) << l;
    }
  }
  EXPECT_EQ(log.matrix->method, "broadband");
  EXPECT_EQ(log.axis_matrix->signals.inputs[2], "floor_z");
  const RunSummary run = run_summary(log);
  EXPECT_EQ(run.n_samples, 20001);
  EXPECT_EQ(run.n_lost, 0);
  EXPECT_EQ(transmissibilities(log, *log.axis_matrix->response).size(), 3u);
  EXPECT_EQ(log.axes[0].floor.envelope.first_time_s, 0);
}

TEST_F(ToyLog, NoiseIsNotKnownWithoutAModel) {
  AnalysisPlan what = plan();
  what.unmodelled = "nobody knows";
  const auto noise = noise_summaries(analyse(write([](Index) { return false; }), what));
  ASSERT_EQ(noise.size(), 3u);
  EXPECT_FALSE(noise[0].rms_acceleration.has_value());
  EXPECT_FALSE(noise[0].share.has_value());
  EXPECT_EQ(noise[0].missing, "nobody knows");
}

/// Without any noise, passive and without damping: what estimators leave of resonances is no noise.
TEST_F(ToyLog, NoNoiseIsNone) {
  for (const SampledLoop& loop : {open_loop(plant_), loop_}) {
    record_ = toy::simulate(loop, record_.inputs.bottomRows(20000), VectorXd::Zero(loop.A.rows()));
    const LogAnalysis log = analyse(write([](Index) { return false; }), plan_with_model(loop));
    for (const NoiseSummary& noise : noise_summaries(log)) {
      EXPECT_EQ(noise.missing, "");
      // 20 000 steps of an undamped motion, each rounded.
      EXPECT_LE(noise.share.value_or(1), 1e-10) << noise.axis;
    }
    // Nor is it error of the response: resonances lie within a parabola of some frequencies.
    for (const auto* identified : {&log.matrix, &log.axis_matrix}) {
      for (std::size_t l = 0; l < plan().frequencies_hz.size(); ++l) {
        const auto exact = transfer(loop, 2 * toy::pi * plan().frequencies_hz[l]);
        EXPECT_LE(((*identified)->response->T[l] - exact).norm(), 1e-8 * exact.norm()) << l;
      }
    }
  }
}

/// Axes that share a floor have one input between them: the others' responses stay what they are
/// without the axis that was added, which has one of its own.
TEST_F(ToyLog, AxesMayShareAFloorAndAFrame) {
  const auto path = write([](Index) { return false; });
  const LogAnalysis apart = analyse(path, plan_with_model(loop_));
  AnalysisPlan what = plan_with_model(loop_);
  what.axes.push_back({"across", "floor_x", "b"});
  const LogAnalysis shared = analyse(path, what);
  ASSERT_TRUE(shared.axis_matrix->response.has_value()) << shared.axis_matrix->missing;
  EXPECT_EQ(shared.axis_matrix->signals.inputs, apart.axis_matrix->signals.inputs);
  EXPECT_EQ(shared.axis_matrix->signals.outputs, apart.axis_matrix->signals.outputs);
  const auto before = transmissibilities(apart, *apart.axis_matrix->response);
  const auto after = transmissibilities(shared, *shared.axis_matrix->response);
  ASSERT_EQ(after.size(), 4u);
  for (std::size_t a = 0; a < before.size(); ++a) {
    EXPECT_EQ(after[a].value, before[a].value) << a;
    EXPECT_EQ(after[a].upper, before[a].upper) << a;
  }
  for (std::size_t l = 0; l < what.frequencies_hz.size(); ++l) {
    const auto exact = transfer(loop_, 2 * toy::pi * what.frequencies_hz[l]);
    // As in NoNoiseIsNone.
    EXPECT_NEAR(after[3].value[l], std::abs(exact(1, 0)), 1e-8 * exact.norm()) << l;
  }
  // It makes of the floor what its frame does, and the rest is none.
  const auto noise = noise_summaries(shared);
  ASSERT_EQ(noise.size(), 4u);
  EXPECT_EQ(noise[3].rms_acceleration, noise[1].rms_acceleration);
  EXPECT_LE(noise[3].share.value(), 1e-10);
}

/// A floor signal that follows from others is no input, and is held to what follows from them.
TEST_F(ToyLog, AFloorThatDependsOnOthersIsNoInputAndIsChecked) {
  const auto path = write([](Index) { return false; });
  AnalysisPlan what = plan_with_model(loop_);
  what.axes.push_back({"slanted", "floor_z", "a"});
  what.axis_signals = signals_by_name(plan().axes);
  what.axis_signals.dependent_floors = {"floor_z"};
  what.axis_signals.output.push_back(0);
  // floor_z taken for (x + y) / 2: the floor moves by (1, 1, 0) while it moves by one.
  what.axis_signals.along.conservativeResize(4, Eigen::NoChange);
  what.axis_signals.along.row(3) << 1, 1, 0;
  what.model->floors.conservativeResize(4, Eigen::NoChange);
  what.model->floors.row(3) << 0.5, 0.5, 0;
  const LogAnalysis strays = analyse(path, what);
  EXPECT_FALSE(strays.axis_matrix->response.has_value());
  EXPECT_EQ(strays.axis_matrix->missing.find("floor_z is not what the inputs say of a floor"), 0u)
      << strays.axis_matrix->missing;
  what.model->floors.row(3) << 0, 0, 1;  // what it is
  const LogAnalysis log = analyse(path, what);
  ASSERT_TRUE(log.axis_matrix->response.has_value()) << log.axis_matrix->missing;
  const auto slanted = transmissibilities(log, *log.axis_matrix->response)[3];
  for (std::size_t l = 0; l < what.frequencies_hz.size(); ++l) {
    const auto exact = transfer(loop_, 2 * toy::pi * what.frequencies_hz[l]);
    EXPECT_NEAR(slanted.value[l], std::abs(exact(0, 0) + exact(0, 1)), 1e-8 * exact.norm()) << l;
  }
}

/// A monitor of the floor that shows something else is none of the floor's response.
TEST_F(ToyLog, AFloorChannelThatIsNotTheFloorIsRefused) {
  floor_z_ = -1;
  const LogAnalysis log = analyse(write([](Index) { return false; }), plan_with_model(loop_));
  EXPECT_TRUE(log.matrix->response.has_value()) << log.matrix->missing;
  EXPECT_FALSE(log.axis_matrix->response.has_value());
  EXPECT_EQ(log.axis_matrix->missing.find("floor_z is not what the inputs say of a floor"), 0u)
      << log.axis_matrix->missing;
}

TEST_F(ToyLog, NoiseApartFromTheFloorIsMeasured) {
  // White noise of 2e-5 m/s^2 rms on one output: sqrt(79 / 250) of it between 1 and 80 Hz.
  std::normal_distribution<double> normal;
  const VectorXd added = VectorXd::NullaryExpr(20001, [&] { return 2e-5 * normal(random_); });
  record_.outputs.col(1) += added;
  const auto path = write([](Index) { return false; });
  const auto noise = noise_summaries(analyse(path, plan_with_model(loop_)));
  // What was added and nothing else, but for the last digits of what it was added to.
  const double exact = band_rms(power_of(added, rate), 1, 80);
  EXPECT_NEAR(noise[1].rms_acceleration.value(), exact, 1e-9 * exact);
  EXPECT_NEAR(exact / (2e-5 * std::sqrt(79.0 / 250)), 1, 0.1);
  EXPECT_LT(noise[0].rms_acceleration.value(), 1e-10 * exact);
  // A model that is wrong by 1 % in its gain leaves 1 % of the motion: noise at most, and said so.
  AnalysisPlan wrong = plan_with_model(loop_);
  wrong.model->loop.C *= 0.99;
  wrong.model->loop.D *= 0.99;
  EXPECT_NEAR(noise_summaries(analyse(path, wrong))[0].share.value(), 0.01, 1e-6);
}

TEST_F(ToyLog, NoiseBehindAGapIsKnownOnceTheLoopHasForgotten) {
  const auto late = [](Index k) { return k < 2000; };
  const auto noise = noise_summaries(analyse(write(late), plan_with_model(loop_)));
  // The leak of 0.05 Hz forgets by 1e-4 in 29 s of 36, so that less than half is left.
  EXPECT_FALSE(noise[0].rms_acceleration.has_value());
  EXPECT_NE(noise[0].missing.find("has gaps"), std::string::npos);
  const SampledLoop quick =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.5, 1 / rate));
  record_ = toy::simulate(quick, record_.inputs.bottomRows(20000), VectorXd::Zero(quick.A.rows()));
  const LogAnalysis log = analyse(write(late), plan_with_model(quick));
  EXPECT_LE(noise_summaries(log)[0].share.value(), 1e-4);
  EXPECT_NEAR(log.axes[0].frame.envelope.first_time_s, 4, 1e-12);
  // One lost sample is put in.
  const auto one =
      noise_summaries(analyse(write([](Index k) { return k == 500; }), plan_with_model(quick)));
  EXPECT_LE(one[0].share.value(), 0.02);
  // An undamped frame never forgets.
  const SampledLoop open = open_loop(plant_);
  record_ = toy::simulate(open, record_.inputs.bottomRows(20000), VectorXd::Zero(6));
  EXPECT_FALSE(noise_summaries(analyse(write(late), plan_with_model(open)))[0].share.has_value());
}

TEST_F(ToyLog, WhyNothingIsIdentifiedIsTrue) {
  const auto missing = [&](const std::function<bool(Index)>& lost) {
    return analyse(write(lost), plan()).matrix->missing;
  };
  // What is expected of the run is 40 s.
  EXPECT_EQ(missing([](Index k) { return k >= 500; }),
            "the log has 1 s, a response of 3 inputs needs 6.25 s");
  EXPECT_EQ(missing([](Index k) { return k >= 1100 || (k >= 400 && k < 600); }),
            "the longest stretch of the log without a gap has 1 s, a response of 3 inputs needs "
            "6.25 s");
  const auto still = [&](Index first, Index n) {
    record_.inputs.middleCols(first, n).setZero();
    return missing([](Index) { return false; });
  };
  // Bursts about 5 and 40 Hz, whose spectra end within 5 Hz (1e-12 of the power, 0.2 s wide).
  for (Index k = 0; k < record_.inputs.rows(); ++k) {
    const double t = static_cast<double>(k) / rate - 20, burst = std::exp(-t * t / 0.08);
    record_.inputs(k, 0) = burst * std::sin(2 * toy::pi * 5 * t);
    record_.inputs(k, 1) = burst * std::sin(2 * toy::pi * 40 * t);
  }
  EXPECT_EQ(still(2, 0), "at none of the frequencies do all inputs move");
  EXPECT_EQ(still(1, 1), "leg_2 does not move at any of the frequencies");
  EXPECT_EQ(still(1, 2), "leg_2, leg_3 do not move at any of the frequencies");
  EXPECT_EQ(still(0, 3), "the inputs do not move at any of the frequencies");
}

TEST_F(ToyLog, PeriodsWhoseMeasurementWasRejectedAreCounted) {
  stillframe_msgs::loop_records_t records{};
  records.run_id = 5;
  records.n_records = 5;
  records.records.resize(5);
  // None, missing, late, not finite, out of range: the last three were there and rejected.
  for (std::int32_t i = 0; i < 5; ++i) records.records[static_cast<std::size_t>(i)].defect = i;
  {
    LogWriter log(folder_ / "run.lcm");
    log.write(channels::run_info, info());
    log.write(channels::measurement, measurement(0));
    log.write(channels::loop, records);
  }
  const RunSummary run = run_summary(analyse(folder_ / "run.lcm", {}));
  EXPECT_EQ(run.n_periods, 5);
  EXPECT_EQ(run.n_discarded, 3);
}

// In step all measurements are answered but those that the controller says it lost; by the clock
// the controller's periods tell, where the log holds them.
TEST_F(ToyLog, WhatTheControllerCommandedIsItsOwnAccount) {
  const auto given = [&](const char* mode, std::int32_t n_records) {
    stillframe_msgs::loop_records_t records{};
    records.run_id = 5;
    records.n_records = n_records;
    records.records.resize(static_cast<std::size_t>(n_records));
    for (std::size_t i = 0; i < records.records.size(); ++i) records.records[i].sent = i != 2;
    auto head = info();
    head.mode = mode;
    head.n_samples = 100;
    stillframe_msgs::timing_t timing{};
    timing.run_id = 5;
    timing.source = "controller";
    timing.n_lost = 7;
    {
      LogWriter log(folder_ / "run.lcm");
      log.write(channels::run_info, head);
      for (Index k = 0; k < 90; ++k) log.write(channels::measurement, measurement(k));
      if (n_records > 0) log.write(channels::loop, records);
      log.write(channels::timing, timing);
    }
    return run_summary(analyse(folder_ / "run.lcm", {})).n_commands_given;
  };
  EXPECT_EQ(given("lock_step", 0), 93);
  EXPECT_EQ(given("wall_clock", 6), 5);
  EXPECT_FALSE(given("wall_clock", 0).has_value());
}

TEST_F(ToyLog, LostSamplesLeaveGapsAndAreSaid) {
  const LogAnalysis log =
      analyse(write([](Index k) { return k == 3000 || (k >= 9000 && k < 9500); }), plan());
  EXPECT_EQ(log.scan.measurements.n_lost, 501);
  EXPECT_EQ(run_summary(log).n_lost, 501);
  EXPECT_EQ(log.axis_matrix->n_filled, 1);
  EXPECT_EQ(log.axes[0].floor.envelope.n_samples, 20001);
  EXPECT_TRUE(std::isnan(log.axes[0].floor.levels[182]));  // 9100 to 9150
  ASSERT_TRUE(log.matrix->response.has_value()) << log.matrix->missing;
  for (std::size_t l = 0; l < log.matrix->response->T.size(); ++l) {
    const auto exact = transfer(loop_, 2 * toy::pi * log.matrix->response->frequencies_hz[l]);
    EXPECT_LT((log.matrix->response->T[l] - exact).norm(), 4e-2 * exact.norm()) << l;
  }
}

TEST_F(ToyLog, InputsThatMoveTogetherAreSaid) {
  record_.inputs.col(2) = record_.inputs.col(0);
  const LogAnalysis log = analyse(write([](Index) { return false; }), plan());
  EXPECT_FALSE(log.matrix->response.has_value());
  EXPECT_NE(log.matrix->missing.find("do not move independently"), std::string::npos);
}

TEST_F(ToyLog, AnAxisThatIsNotThereIsAnError) {
  AnalysisPlan what = plan();
  what.axes[0].frame = "lens_x";
  const auto path = write([](Index k) { return k > 100; });
  expect_error<InputError>([&] { analyse(path, what); }, "called 'lens_x'");
}

TEST_F(ToyLog, MultisinesAreIdentifiedByTheirLines) {
  const MultisinePlan lines = toy::plan();
  record_ = toy::simulate(loop_, toy::multisine(lines, 1e-3), VectorXd::Zero(loop_.A.rows()));
  AnalysisPlan what = plan();
  what.axes.clear();
  what.multisine = lines;
  const LogAnalysis log = analyse(write([](Index k) { return k == 4100; }), what);
  EXPECT_EQ(log.matrix->method, "multisine");
  EXPECT_EQ(log.matrix->n_filled, 1);
  ASSERT_TRUE(log.matrix->response.has_value()) << log.matrix->missing;
  for (std::size_t l = 0; l < lines.frequencies_hz.size(); ++l) {
    const auto exact = transfer(loop_, 2 * toy::pi * lines.frequencies_hz[l]);
    EXPECT_LT((log.matrix->response->T[l] - exact).norm(), 1e-6 * exact.norm()) << l;
  }
  EXPECT_FALSE(log.axis_matrix.has_value());
  // Half of the run is no experiment.
  const LogAnalysis half = analyse(write([](Index k) { return k > 4500; }), what);
  EXPECT_FALSE(half.matrix->response.has_value());
  EXPECT_NE(half.matrix->missing.find("has lost"), std::string::npos) << half.matrix->missing;
}

}  // namespace
}  // namespace stillframe::report

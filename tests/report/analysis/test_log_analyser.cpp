#include <gtest/gtest.h>

#include <random>

#include "core/yaml/input_error.hpp"
#include "report/analysis/log_analyser.hpp"
#include "report/analysis/summaries.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/report/toy_frame.hpp"

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
    message.floor_acceleration.assign(3, 0);
    message.frame_acceleration.assign(6, 0);
    for (Index i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      message.floor_acceleration[at] = message.frame_acceleration[at + 3] = record_.inputs(k, i);
      message.frame_acceleration[at] = record_.outputs(k, i);
    }
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
  LogAnalysis analyse(const std::filesystem::path& path, const AnalysisPlan& what) const {
    return analyse_log(path, {}, [&](const auto&) { return what; });
  }

  ScratchFolder folder_;
  std::mt19937_64 random_{3};
  toy::Frame frame_;
  SampledPlant plant_ = sample_and_hold(frame_.plant(), toy::sampled_at(1 / rate, 1));
  SampledLoop loop_ =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, 1 / rate));
  toy::Record record_;
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
  // Nothing but rounding and the parabola is unexplained.
  for (const NoiseSummary& noise : noise_summaries(log, *log.axis_matrix->response)) {
    EXPECT_LT(noise.share, 1e-2) << noise.axis;
  }
}

TEST_F(ToyLog, NoiseApartFromTheFloorIsMeasured) {
  // White noise of 2e-5 m/s^2 rms on one output: sqrt(79 / 250) of it between 1 and 80 Hz.
  std::normal_distribution<double> normal;
  for (double& value : record_.outputs.col(1)) value += 2e-5 * normal(random_);
  const LogAnalysis log = analyse(write([](Index) { return false; }), plan());
  const auto noise = noise_summaries(log, *log.axis_matrix->response);
  // 9 frequencies of some 25 degrees of freedom each, unevenly weighted: about 10 %, three times
  // that.
  EXPECT_NEAR(noise[1].rms_acceleration / (2e-5 * std::sqrt(79.0 / 250)), 1, 0.3);
  EXPECT_LT(noise[0].rms_acceleration, 0.2 * noise[1].rms_acceleration);
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

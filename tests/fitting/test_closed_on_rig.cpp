#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/closing.hpp"
#include "judge/commissioning.hpp"
#include "tests/fitting/small_frame.hpp"
#include "tests/support/hidden_rig.hpp"
#include "tools/commission_text.hpp"

namespace stillframe::judge {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

/// One of whose accelerometers reads something else in one sample; -1: in none.
class BlinkingRig : public controller::HiddenRig {
 public:
  BlinkingRig(const LoopDesign& design, std::int64_t sample, double value)
      : HiddenRig(controller::SimulatedPlant(design.sampled, 0.001), controller::Hidden(3), 1, 3),
        sample_(sample),
        value_(value) {}
  bool receive(controller::Measurement& m) noexcept override {
    if (!HiddenRig::receive(m)) return false;
    for (double& sigma : m.sigma) sigma -= 3;  // its tare
    last = m.seq;
    if (m.seq == sample_) m.frame(1) = value_;
    return true;
  }
  std::int64_t last = 0;  ///< sample

 private:
  std::int64_t sample_;
  double value_;
};

controller::ClosedRecording closed(BlinkingRig& rig, const LoopDesign& design) {
  controller::Policy policy;
  policy.force_limit_n = 1000;
  policy.arming_s = 0.5;
  policy.ramp_in_s = 0.5;
  policy.excitation.kind = controller::ExcitationPlan::Kind::multisine;
  policy.excitation.window_s = 0.2;
  policy.excitation.windows = 2;
  policy.excitation.force_n = added_force(20, design, policy);
  return controller::close_on_rig(rig, design.gains, policy, 0, 3, rig.time(), {}, {});
}

/// The loop answers to no accelerometer of the frame, and what peaks and transfers are made of it
/// drops what is no number: a sample of it is nowhere the beginning of a verdict, and the frame is
/// let go of.
TEST(ClosedOnRig, AnAccelerometerThatGivesNoNumberEndsTheRun) {
  const LoopDesign design =
      make_loop_design(parse_scene(fitting::small_frame_text(), "small_frame"));
  BlinkingRig sound(design, -1, 0);
  const controller::ClosedRecording run = closed(sound, design);
  EXPECT_TRUE(run.frame_peak.allFinite());
  const std::int64_t n = sound.last;
  for (const double value : {no_number, -std::numeric_limits<double>::infinity()}) {
    // While it waits, is active, and ramps out.
    for (const std::int64_t sample : {std::int64_t{3}, n / 2, n - 2500}) {
      SCOPED_TRACE(std::to_string(value) + " " + std::to_string(sample) + "/" + std::to_string(n));
      BlinkingRig rig(design, sample, value);
      try {
        closed(rig, design);
        ADD_FAILURE();
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "accelerometer 2 of the frame gave what is no number");
      }
      EXPECT_FALSE(rig.enabled);
      EXPECT_EQ(rig.acts().norm(), 0);
    }
    // Once the amplifiers are off it is nothing to anybody.
    BlinkingRig rig(design, n - 500, value);
    EXPECT_EQ(closed(rig, design).frame_peak, run.frame_peak);
  }
}

/// Its last window is one of several, whose mean hides it.
TEST(ClosedOnRig, ASensorThatSticksInTheLastWindowIsNamed) {
  const LoopDesign design =
      make_loop_design(parse_scene(fitting::small_frame_text(), "small_frame"));
  BlinkingRig rig(design, -1, 0);
  controller::ClosedRecording run = closed(rig, design);
  controller::RigFile file;
  file.frame = {"a", "b", "c"};
  const auto require = [&] {
    require_motion(run.recording, run.n_window, design.gains.sample_rate_hz, design.gains.legs,
                   file);
  };
  EXPECT_NO_THROW(require());
  auto b = run.recording.frame.col(1);
  const Index from = run.recording.windows.back() + run.n_window / 2;
  b.tail(b.size() - from).setConstant(b(from));
  try {
    require();
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(
        std::string(error.what()).starts_with("accelerometer b stood still for 0.1 s, from"))
        << error.what();
  }
}

constexpr double driven_peak = 2;

/// As it is written after a loop that did as predicted, whose accelerometers read these peaks.
tools::Commissioning commissioned(const VectorXd& peaks) {
  const Index n = 8, q = peaks.size();
  ClosedResponse response;
  response.of = q > 0 ? ClosedResponse::Of::frame : ClosedResponse::Of::sigma;
  response.frequencies_hz = VectorXd::LinSpaced(n, 1, 8);
  response.measured = response.predicted = response.along = VectorXd::Ones(n);
  response.passive = VectorXd::Constant(n, 3);
  response.noise = response.along_noise = VectorXd::Constant(n, 1e-3);
  tools::Commissioning all;
  all.closed.emplace();
  all.closed->responses = {response};
  all.closed->run.frame_peak = peaks;
  for (Index i = 0; i < q; ++i) all.rig.frame.push_back("axis_" + std::to_string(i));
  // Accelerometers have offsets, and stand still in the first window.
  all.found.emplace();
  all.found->n_window = 4;
  controller::Recording& recording = all.found->recording;
  recording.frame = Eigen::MatrixXd::Constant(8, q, 9.81);
  recording.frame.row(6).array() -= driven_peak;
  recording.windows = {0, 4};
  recording.driven = {-1, 0};
  all.passed = all.is_closed_well();
  return all;
}

std::string printed(const tools::Commissioning& all) {
  testing::internal::CaptureStdout();
  print_closed(all);
  return testing::internal::GetCapturedStdout();
}

const char* shakes = "That is more than 1.1 times as much: the loop shakes the frame.";

TEST(ClosedOnRig, AFrameIsShakenAtMost1p1TimesAsHard) {
  for (const double part : {0.0, 0.5, 1.09, 1.11, 100.0}) {
    SCOPED_TRACE(part);
    // Whichever of them that is.
    const tools::Commissioning all =
        commissioned((VectorXd(3) << 0.1, part * driven_peak, 0).finished());
    const bool harder = part > 1.1;
    EXPECT_EQ(all.is_shaken_harder(), harder);
    EXPECT_EQ(all.passed, !harder);
    const tools::Json said = to_json(all);
    EXPECT_EQ(said["passed"], !harder);
    EXPECT_EQ(said["closed"]["as_predicted"], true);
    EXPECT_EQ(said["closed"]["shaken_harder"], harder);
    EXPECT_NEAR(said["closed"]["frame_peak_driven_m_s2"][1].get<double>(), driven_peak, 1e-12);
    EXPECT_EQ(printed(all).find(shakes) != std::string::npos, harder && part < 2);
  }
}

/// Another axis that is louder is no excuse, and of one that hears hardly anything nothing is said.
TEST(ClosedOnRig, AnAxisIsShakenAtMostTwiceAsHard) {
  for (const double quiet : {0.001, 0.2}) {
    for (const double times : {0.9, 1.3, 1.9, 2.1, 5.0}) {
      SCOPED_TRACE(std::to_string(quiet) + " " + std::to_string(times));
      tools::Commissioning all =
          commissioned((VectorXd(3) << driven_peak, times * quiet * driven_peak, 0.1).finished());
      all.found->recording.frame(6, 1) = 9.81 - quiet * driven_peak;
      const bool harder = times > 2 && quiet > 0.1;
      EXPECT_EQ(all.is_shaken_harder(), harder);
      EXPECT_EQ(all.is_closed_well(), !harder);
      EXPECT_EQ(printed(all).find("without the loop was read by axis_1: the loop shakes") !=
                    std::string::npos,
                harder)
          << printed(all);
    }
  }
}

TEST(ClosedOnRig, WhatNobodyKnowsIsNoPass) {
  for (Index bad = 0; bad < 3; ++bad) {
    VectorXd peaks = VectorXd::Constant(3, 0.1);
    peaks(bad) = no_number;
    EXPECT_TRUE(commissioned(peaks).is_shaken_harder()) << bad;
    EXPECT_FALSE(commissioned(peaks).passed) << bad;
  }
  // Nothing moved without the loop, and something does with it.
  tools::Commissioning all = commissioned(VectorXd::Constant(3, 0.1));
  all.found->recording.frame.setConstant(9.81);
  EXPECT_TRUE(all.is_shaken_harder());
  EXPECT_FALSE(all.is_closed_well());
  all.closed.reset();
  EXPECT_FALSE(all.is_closed_well());
}

/// Of a scene that was corrected before, of a rig without accelerometers, and where nothing was
/// recorded: nothing to compare by, which is said, and what was predicted is all that is asked.
TEST(ClosedOnRig, WithoutADriveThereIsNothingToCompareBy) {
  const VectorXd peaks = VectorXd::Constant(3, 100);
  tools::Commissioning corrected = commissioned(peaks), unrecorded = corrected;
  corrected.found.reset();
  unrecorded.found->recording = {};
  for (const tools::Commissioning& all : {corrected, unrecorded, commissioned(VectorXd(0))}) {
    EXPECT_FALSE(all.is_shaken_harder());
    EXPECT_TRUE(all.is_closed_well());
    const tools::Json said = to_json(all)["closed"];
    EXPECT_TRUE(said["shaken_harder"].is_null());
    EXPECT_TRUE(said["frame_peak_driven_m_s2"].is_null());
    EXPECT_EQ(printed(all).find("without the loop"), std::string::npos) << printed(all);
  }
}

/// Noise hides all of it: no number is made of none, in JSON or in a sentence.
TEST(ClosedOnRig, ALoopThatNoiseHidesIsNotPassed) {
  tools::Commissioning all = commissioned(VectorXd::Constant(3, 0.1));
  ClosedResponse& response = all.closed->responses.front();
  response.noise = response.along_noise = response.measured;
  EXPECT_FALSE(all.is_closed_well());
  const tools::Json said = to_json(all)["closed"]["responses"][0];
  for (const char* key : {"mean_db", "mean_doubt_db", "worst_db", "worst_hz"}) {
    EXPECT_TRUE(said[key].is_null()) << key;
  }
  EXPECT_EQ(said["as_predicted"], false);
  EXPECT_NE(printed(all).find("Closed: noise hides what added forces make of the accelerations of "
                              "the frame. Take a larger --force, or more --windows."),
            std::string::npos)
      << printed(all);
  // Lines are told, and what lies along the prediction is not: the rig answers in other directions.
  response.noise = VectorXd::Constant(response.measured.size(), 1e-3);
  response.along = 1e-3 * response.along;
  EXPECT_FALSE(all.is_closed_well());
  const tools::Json mean = to_json(all)["closed"]["responses"][0];
  EXPECT_TRUE(mean["mean_db"].is_null() && mean["mean_doubt_db"].is_null()) << mean;
  EXPECT_FALSE(mean["worst_db"].is_null());
  EXPECT_NE(printed(all).find("all together hidden by noise; the law is seen to act at 8. Take a "
                              "larger --force, or more --windows."),
            std::string::npos)
      << printed(all);
}

}  // namespace
}  // namespace stillframe::judge

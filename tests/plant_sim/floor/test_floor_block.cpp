#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "plant_sim/floor/floor_block.hpp"
#include "tests/plant_sim/floor/message_of.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::floor {
namespace {

using test::ScratchFolder;
using testing::message_of;

FloorSpec read(const std::string& text, double rate = 1000.0, Eigen::Index inputs = 6) {
  return read_floor_block(YamlReader::from_text(text, "floor.yaml"), rate, inputs);
}

FloorSpec read_named(const std::string& text) {
  return read_floor_block(YamlReader::from_text(text, "floor.yaml"), 1000.0,
                          std::vector<std::string>{"north", "south"});
}

TEST(FloorBlock, DefaultsAreAsDocumented) {
  const auto recording =
      std::get<RecordingSpec>(read("recording: {file: a.csv, axes: {c: z}}").kind);
  EXPECT_EQ(recording.file, "a.csv");
  EXPECT_EQ(recording.scale, 1.0);
  EXPECT_EQ(recording.start_s, 0.0);
  EXPECT_EQ(recording.high_pass_hz, 0.5);
  ASSERT_EQ(recording.axes.size(), 1u);
  EXPECT_EQ(recording.axes[0].column, "c");
  EXPECT_EQ(recording.axes[0].axis, 2);
  const auto plan =
      std::get<MultisinePlan>(read("multisine: {frequencies_hz: [3, 1], amplitude: 2e-3}").kind);
  EXPECT_EQ(plan.sample_rate_hz, 1000.0);
  EXPECT_EQ(plan.frequencies_hz, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(plan.n_blocks, 6);
  EXPECT_EQ(plan.ramp_s, 4.0);
  EXPECT_EQ(plan.window_s, 8.0);
  EXPECT_EQ(plan.amplitude, 2e-3);
  const auto white = std::get<WhiteSpec>(read("white: {rms: 1e-4, duration_s: 1.5}").kind);
  EXPECT_EQ(white.seed, 1u);
  EXPECT_EQ(white.high_pass_hz, 0.5);
  EXPECT_EQ(white.n_samples, 1500);
  EXPECT_EQ(std::get<StillSpec>(read("still: {duration_s: 0.001}").kind).n_samples, 1);
}

struct BadText {
  const char* name;
  std::string text, message;
};

void PrintTo(const BadText& bad, std::ostream* out) { *out << bad.name; }

class BadBlock : public ::testing::TestWithParam<BadText> {};

TEST_P(BadBlock, IsRefusedWithLineAndColumn) {
  EXPECT_EQ(message_of<InputError>([&] { read(GetParam().text); }),
            "floor.yaml:" + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, BadBlock,
    ::testing::Values(
        BadText{"unknown_kind", "records: {}",
                "1:1: records: unknown key (did you mean 'recording'?); allowed: recording, "
                "multisine, white, noise, step, impact, sine_sweep, still, sum"},
        BadText{"no_kind", "{}",
                "1:1: found 0 kinds of floor, allowed is exactly one of recording, multisine, "
                "white, noise, step, impact, sine_sweep, still, sum"},
        BadText{"two_kinds", "still: {duration_s: 1}\nwhite: {rms: 1, duration_s: 1}",
                "1:1: found 2 kinds of floor, allowed is exactly one of recording, multisine, "
                "white, noise, step, impact, sine_sweep, still, sum"},
        BadText{"unknown_key", "still: {duraton_s: 1}",
                "1:9: still.duraton_s: unknown key (did you mean 'duration_s'?); allowed: "
                "duration_s"},
        BadText{"still_without_duration", "still: {}",
                "1:8: still: the key 'duration_s' is missing"},
        BadText{"shorter_than_a_sample", "still: {duration_s: 1e-4}",
                "1:21: still.duration_s: found 0.0001, allowed is from 0.001 (one sample) to "
                "16666.666"},
        BadText{"too_long", "white: {rms: 1, duration_s: 1e9}",
                "1:29: white.duration_s: found 1000000000, allowed is from 0.001 (one sample) to "
                "16666.666"},
        BadText{"white_without_rms", "white: {duration_s: 1}",
                "1:8: white: the key 'rms' is missing"},
        BadText{"negative_rms", "white: {rms: -1, duration_s: 1}",
                "1:14: white.rms: found '-1', allowed is a number above 0"},
        BadText{"negative_seed", "white: {rms: 1, duration_s: 1, seed: -1}",
                "1:38: white.seed: found '-1', allowed is a whole number from 0 up"},
        BadText{"corner_above_nyquist", "white: {rms: 1, duration_s: 1, high_pass_hz: 500}",
                "1:46: white.high_pass_hz: found 500, allowed is a number below 500, half the "
                "control rate"},
        BadText{"no_lines", "multisine: {amplitude: 1, frequencies_hz: []}",
                "1:43: multisine.frequencies_hz: found no line, allowed is one or more"},
        BadText{"off_the_grid", "multisine:\n  amplitude: 1\n  frequencies_hz: [1, 1.25]",
                "3:23: multisine.frequencies_hz[2]: found 1.25, allowed is a whole multiple of 0.5 "
                "Hz (4 / window_s)"},
        BadText{"above_nyquist", "multisine: {amplitude: 1, frequencies_hz: [500]}",
                "1:44: multisine.frequencies_hz[1]: found 500, allowed is a line below 500 Hz, "
                "half the control rate"},
        BadText{"line_twice", "multisine: {amplitude: 1, frequencies_hz: [2, 3, 2.0]}",
                "1:50: multisine.frequencies_hz[3]: found 2, allowed is each line once"},
        BadText{"zero_line", "multisine: {amplitude: 1, frequencies_hz: [0]}",
                "1:44: multisine.frequencies_hz[1]: found '0', allowed is a number above 0"},
        BadText{"no_amplitude", "multisine: {frequencies_hz: [1]}",
                "1:12: multisine: the key 'amplitude' is missing"},
        BadText{"uneven_window", "multisine: {amplitude: 1, frequencies_hz: [1], window_s: 8.0001}",
                "1:58: multisine.window_s: found 8.0001, allowed is a whole number of samples at "
                "the control rate of 1000 Hz"},
        BadText{"uneven_ramp", "multisine: {amplitude: 1, frequencies_hz: [1], ramp_s: 1e-4}",
                "1:56: multisine.ramp_s: found 0.0001, allowed is a whole number of samples at the "
                "control rate of 1000 Hz"},
        BadText{"endless", "multisine: {amplitude: 1, frequencies_hz: [1], ramp_s: 4000}",
                "1:12: multisine: the experiment is too long: 6 blocks of 4008 s on 6 inputs are "
                "more than 100000000 values"},
        BadText{"no_file", "recording: {axes: {a: x}}",
                "1:12: recording: the key 'file' is missing"},
        BadText{"no_axes", "recording: {file: a.csv}",
                "1:12: recording: the key 'axes' is missing"},
        BadText{"empty_axes", "recording: {file: a.csv, axes: {}}",
                "1:32: recording.axes: found nothing, allowed is a map as in {ax: x, ay: y, az: "
                "z}"},
        BadText{"unknown_axis", "recording: {file: a.csv, axes: {a: up}}",
                "1:36: recording.axes.a: found 'up', allowed is one of x, y, z, rx, ry, "
                "rz"},
        BadText{"axis_twice", "recording: {file: a.csv, axes: {a: x, b: x}}",
                "1:42: recording.axes.b: found 'x', which column a already moves; allowed is one "
                "column for each axis"},
        BadText{"zero_scale", "recording: {file: a.csv, scale: 0, axes: {a: x}}",
                "1:33: recording.scale: found '0', allowed is a number above 0"},
        BadText{"negative_start", "recording: {file: a.csv, start_s: -1, axes: {a: x}}",
                "1:35: recording.start_s: found '-1', allowed is a number that is not negative"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(FloorBlock, DefaultsOfEventsAndNoiseAreAsDocumented) {
  const auto noise = std::get<NoiseSpec>(read("noise: {vc: D, duration_s: 7200}").kind);
  EXPECT_EQ(noise.seed, 1u);
  EXPECT_EQ(noise.high_pass_hz, 0.05);
  EXPECT_EQ(noise.period_s, 1000.0);
  EXPECT_EQ(noise.n_samples, 7200000);
  EXPECT_TRUE(noise.axes.empty());
  const auto step =
      std::get<CourseSpec>(read_named("step: {height: -1, rise_s: 0.5, input: south}").kind);
  EXPECT_FALSE(step.target.axis);
  EXPECT_EQ(step.target.input, 1);
  EXPECT_EQ(step.begin, 0);
  EXPECT_EQ(step.n_samples, 502);
  const auto sweep = std::get<CourseSpec>(
      read("sine_sweep: {from_hz: 1, to_hz: 9, amplitude: 1, sweep_s: 8, at_s: 3, axis: rz, "
           "duration_s: 20}")
          .kind);
  EXPECT_FALSE(std::get<SweepCourse>(sweep.course).linear);
  EXPECT_EQ(sweep.begin, 3000);
  EXPECT_EQ(sweep.n_samples, 20000);
  EXPECT_EQ(sweep.target.about, Eigen::Vector3d::Zero());
  EXPECT_TRUE(
      read("sum: [{still: {duration_s: 1}}, {recording: {file: a.csv, axes: {a: x}}}]").recorded());
  EXPECT_FALSE(read("sum: [{still: {duration_s: 1}}]").recorded());
}

INSTANTIATE_TEST_SUITE_P(
    EventsAndNoise, BadBlock,
    ::testing::Values(
        BadText{"no_target", "step: {height: 1, rise_s: 1}",
                "1:7: step: needs either 'axis' (x, y, z, rx, ry or rz) or 'input' (the name of an "
                "input)"},
        BadText{"two_targets", "step: {height: 1, rise_s: 1, axis: x, input: a}",
                "1:7: step: needs either 'axis' (x, y, z, rx, ry or rz) or 'input' (the name of an "
                "input)"},
        BadText{"unknown_input", "step: {height: 1, rise_s: 1, input: a}",
                "1:37: step.input: there is no input named 'a'"},
        BadText{"translation_about", "step: {height: 1, rise_s: 1, axis: x, about: [0, 0, 0]}",
                "1:46: step.about: only the rotations rx, ry and rz are about a point"},
        BadText{"steep", "step: {height: 1, rise_s: 0.003, axis: x}",
                "1:27: step.rise_s: found 0.003, allowed is from 0.004 (4 samples) to 100000"},
        BadText{"cut_off", "impact: {peak: 1, width_s: 1, axis: x, at_s: 4, duration_s: 4.5}",
                "1:61: impact.duration_s: ends before the impact, allowed is 5.002 or more"},
        BadText{"sweep_above_nyquist",
                "sine_sweep: {from_hz: 1, to_hz: 500, amplitude: 1, sweep_s: 9, axis: x}",
                "1:33: sine_sweep.to_hz: found 500, allowed is a frequency below 500 Hz, half the "
                "control rate"},
        BadText{"sweep_of_a_moment",
                "sine_sweep: {from_hz: 1, to_hz: 50, amplitude: 1, sweep_s: 3, axis: x}",
                "1:60: sine_sweep.sweep_s: found 3, allowed is from 4 (4000 samples) to 100000"},
        BadText{"no_density", "noise: {duration_s: 1}",
                "1:8: noise: needs exactly one of vc, peterson, psd"},
        BadText{"two_densities", "noise: {vc: D, peterson: low, duration_s: 1}",
                "1:8: noise: needs exactly one of vc, peterson, psd"},
        BadText{"class", "noise: {vc: H, duration_s: 1}",
                "1:13: noise.vc: found 'H', allowed is one of A, B, C, D, E, F, G"},
        BadText{"descending", "noise: {psd: [[2, 1], [1, 1]], duration_s: 1}",
                "1:23: noise.psd[2]: allowed is [frequency, density], both above 0, the "
                "frequencies ascending"},
        BadText{"one_point", "noise: {psd: [[2, 1]], duration_s: 1}",
                "1:14: noise.psd: found fewer than two points [frequency, density]"},
        BadText{"all_above", "noise: {psd: [[600, 1], [700, 1]], duration_s: 1}",
                "1:14: noise.psd: all its frequencies are above 500 Hz, half the control rate"},
        BadText{"criterion_of_a_rotation", "noise: {vc: D, axes: [x, rx], duration_s: 1}",
                "1:26: noise.axes[2]: vc and peterson are about translations; allowed for a "
                "rotation is psd, in (rad/s^2)^2/Hz"},
        BadText{"noise_axis_twice", "noise: {vc: D, axes: [x, x], duration_s: 1}",
                "1:26: noise.axes[2]: allowed is each once"},
        BadText{"noise_without_end", "noise: {vc: D}",
                "1:8: noise: the key 'duration_s' is missing"},
        BadText{"long_period", "noise: {vc: D, period_s: 20000, duration_s: 1}",
                "1:26: noise.period_s: found 20000, allowed is up to 10000"},
        BadText{"sum_of_nothing", "sum: []",
                "1:6: sum: found nothing, allowed is one floor or more"},
        BadText{"sum_in_a_sum", "sum: [{sum: [{still: {duration_s: 1}}]}]",
                "1:7: sum[1]: a sum within a sum is not allowed"},
        BadText{"kind_in_a_sum", "sum: [{stil: {duration_s: 1}}]",
                "1:8: sum[1].stil: unknown key (did you mean 'still'?); allowed: recording, "
                "multisine, white, noise, step, impact, sine_sweep, still, sum"},
        BadText{"mixed_recording", "recording: {file: a.csv, axes: {a: x, b: rz}}",
                "1:42: recording.axes.b: found 'rz' beside translations or rotations: a file is in "
                "m/s^2 or in rad/s^2; a sum of two recordings has both"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(FloorBlock, TheCallerMustGiveARateAndInputs) {
  EXPECT_THROW(read("still: {duration_s: 1}", 0.0), std::invalid_argument);
  EXPECT_THROW(read("still: {duration_s: 1}", 1000.0, 0), std::invalid_argument);
}

/// A recording of 3 s at 10 Hz beside a floor file that uses it.
struct RecordingBlock : ::testing::Test {
  RecordingBlock() {
    std::string text = "# fs_hz=10 n=31 units=m/s^2\nax,ay\n";
    for (int k = 0; k < 31; ++k) text += "1,2\n";
    csv = folder.write("a.csv", text);
  }
  std::string refused(const std::string& block, double rate = 100.0) {
    const auto yaml = folder.write("f.yaml", block);
    const std::string message = message_of<InputError>(
        [&] { make_floor_source(read_floor_block(YamlReader::from_file(yaml), rate, 6)); });
    const std::string prefix = yaml.string() + ":";
    return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
  }
  ScratchFolder folder;
  std::filesystem::path csv;
};

TEST_F(RecordingBlock, ThePathIsResolvedAgainstTheFileThatNamesIt) {
  const auto yaml = folder.write("f.yaml", "recording: {file: a.csv, axes: {ay: y}}");
  const auto source = make_floor_source(read_floor_block(YamlReader::from_file(yaml), 100.0, 6));
  EXPECT_EQ(source->meaning(), FloorChannels::rigid);
  EXPECT_EQ(source->channels(), 6);
  EXPECT_EQ(source->n_samples(), 301);
  Eigen::VectorXd w(6);
  source->sample(150, w);
  EXPECT_EQ(w(0), 0.0);
  EXPECT_NE(w(1), 0.0);
  EXPECT_EQ(w(2), 0.0);
}

TEST_F(RecordingBlock, AMissingRecordingIsNamedWhereItIsAskedFor) {
  EXPECT_EQ(refused("recording:\n  file: b.csv\n  axes: {ax: x}"),
            "2:9: recording.file: found '" + (folder.path() / "b.csv").string() +
                "', which is missing or no file");
}

TEST_F(RecordingBlock, AColumnThatIsNotThereIsNamed) {
  EXPECT_EQ(refused("recording: {file: a.csv, axes: {ax_: x}}"),
            "1:38: recording.axes.ax_: 'ax_' is no column of " + csv.string() +
                " (did you mean 'ax'?); allowed: ax, ay");
}

TEST_F(RecordingBlock, AStartTooNearTheEndIsRefused) {
  EXPECT_EQ(refused("recording: {file: a.csv, start_s: 2, axes: {ax: x}}"),
            "1:35: recording.start_s: found 1.1 s of " + csv.string() +
                " from start_s on, allowed is more than 2 s");
}

TEST_F(RecordingBlock, ARateOfNoSimpleRatioIsRefused) {
  EXPECT_EQ(refused("recording: {file: a.csv, axes: {ax: x}}", 100.0001),
            "1:19: recording.file: found a recording at 10 Hz, allowed is a rate whose "
            "ratio to the control rate of 100.0001 Hz is one of whole numbers up to 10000");
}

TEST_F(RecordingBlock, ARateBeyondAllMeasureIsShort) {
  folder.write("a.csv", "# fs_hz=1e300 n=1 units=m/s^2\nax\n1\n");
  EXPECT_NE(refused("recording: {file: a.csv, axes: {ax: x}}").find("a recording at 1e+300 Hz"),
            std::string::npos);
}

TEST_F(RecordingBlock, AnUnsoundRecordingIsRefusedWithItsOwnPlace) {
  folder.write("a.csv", "# fs_hz=10 n=2 units=m/s^2\nax\n1\nnan\n");
  EXPECT_EQ(refused("recording: {file: a.csv, axes: {ax: x}}"),
            csv.string() + ":4:1: ax: found 'nan', allowed is a finite number");
}

}  // namespace
}  // namespace stillframe::floor

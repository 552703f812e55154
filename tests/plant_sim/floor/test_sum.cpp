#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/sources.hpp"
#include "tests/plant_sim/floor/message_of.hpp"
#include "tests/support/allocation_count.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::floor {
namespace {

using test::ScratchFolder;
using testing::message_of;

const std::vector<std::string> names = {"left", "middle", "right"};

std::unique_ptr<FloorSource> from(const std::string& text, double rate = 1000.0) {
  return make_floor_source(
      read_floor_block(YamlReader::from_text(text, "floor.yaml"), rate, names));
}

Eigen::VectorXd at(const FloorSource& source, std::int64_t k) {
  Eigen::VectorXd w = Eigen::VectorXd::Constant(source.channels(), NAN);
  source.sample(k, w);
  return w;
}

const std::string sweep =
    "sine_sweep: {axis: ry, about: [1, 2, 3], from_hz: 5, to_hz: 80, amplitude: 1e-3, sweep_s: 2}";
const std::string step = "step: {input: middle, height: 1e-4, rise_s: 0.05, at_s: 0.7}";
const std::string noise = "noise: {vc: C, axes: [x, z], duration_s: 1.5, high_pass_hz: 1}";

TEST(SumFloor, IsTheSumOfItsParts) {
  // The noise first: those behind it would have streams of their own.
  const auto sum = from("sum: [{" + noise + "}, {" + sweep + "}, {" + step + "}]");
  const auto a = from(sweep), b = from(step), c = from(noise);
  ASSERT_EQ(sum->meaning(), FloorChannels::rigid_and_inputs);
  ASSERT_EQ(sum->channels(), 9);
  EXPECT_EQ(sum->n_samples(), 2002);  // the longest, and the sample in which it comes to rest
  for (std::int64_t k = -1; k < 2010; ++k) {
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(9);
    expected.head(6) = at(*a, k) + at(*c, k);
    expected.tail(3) = at(*b, k);
    EXPECT_EQ(at(*sum, k), expected) << k;
  }
  const std::vector<bool> moves = {true, false, true, false, true, false, false, true, false};
  for (Eigen::Index i = 0; i < 9; ++i) EXPECT_EQ(sum->moves(i), moves[static_cast<size_t>(i)]) << i;
}

TEST(SumFloor, HasOnlyTheChannelsOfItsParts) {
  EXPECT_EQ(from("sum: [{" + step + "}, {still: {duration_s: 1}}]")->meaning(),
            FloorChannels::inputs);
  const auto rigid = from("sum: [{impact: {axis: z, peak: 1, width_s: 0.02}}]");
  EXPECT_EQ(rigid->meaning(), FloorChannels::rigid);
  EXPECT_EQ(rigid->channels(), 6);
  EXPECT_NE(at(*rigid, 10)(2), 0.0);
}

TEST(SumFloor, SamplingAllocatesNothing) {
  // The noise first: those behind it would have streams of their own.
  const auto sum = from("sum: [{" + noise + "}, {" + sweep + "}, {" + step + "}]");
  Eigen::VectorXd w(9);
  const auto before = test::allocation_count();
  for (std::int64_t k = 0; k < 2000; ++k) sum->sample(k, w);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(Targets, ARotationLeavesItsPointWhereItIs) {
  const Eigen::Vector3d about(1, 2, 3), r(-0.5, 0.7, 0.1);
  for (Eigen::Index axis = 3; axis < 6; ++axis) {
    const Eigen::VectorXd u = rigid_pattern(axis, about);
    const Eigen::Vector3d theta = u.tail<3>();
    EXPECT_EQ(theta, Eigen::Vector3d::Unit(axis - 3));
    EXPECT_LT((u.head<3>() + theta.cross(about)).norm(), 1e-15);
    EXPECT_LT((u.head<3>() + theta.cross(r) - theta.cross(r - about)).norm(), 1e-15);
  }
  EXPECT_EQ(rigid_pattern(1, about), Eigen::VectorXd::Unit(6, 1));
}

/// Exact double integral of one channel from rest; answers velocity and position at the end.
std::pair<double, double> integral(const FloorSource& source, Eigen::Index channel, double rate) {
  long double v = 0, x = 0;
  const long double T = 1.0L / rate;
  Eigen::VectorXd w(source.channels());
  for (std::int64_t k = 0; k < source.n_samples(); ++k) {
    source.sample(k, w);
    x += T * (v + T * w(channel) / 2);
    v += T * w(channel);
  }
  return {static_cast<double>(v), static_cast<double>(x)};
}

TEST(SumFloor, RecordingsAndWhiteNoiseRingOut) {
  const double rate = 300.0;
  const ScratchFolder folder;
  std::string text = "# fs_hz=50 n=301 units=m/s^2\na\n";
  for (int k = 0; k < 301; ++k) text += std::to_string(1 + 0.1 * (k % 7)) + "\n";
  const auto csv = folder.write("a.csv", text);
  const std::string recording = "recording: {file: '" + csv.string() + "', axes: {a: z}}";
  const std::string white = "white: {rms: 1, duration_s: 6}";
  const auto sum =
      from("sum: [{" + recording + "}, {" + white + "}, {still: {duration_s: 60}}]", rate);
  ASSERT_EQ(sum->n_samples(), 60 * 300);
  for (const Eigen::Index channel : {2, 6}) {
    const auto [v, x] = integral(*sum, channel, rate);
    // Accelerations of 1 m/s^2; the recursion of the filter rounds by 1e-16 (rate / (2 pi f_c))^2 =
    // 1e-12 m/s^2 at low frequencies, for 38 s: 1e-12 sqrt(38 s / rate) in velocity, times 60 s.
    EXPECT_NEAR(v, 0.0, 1e-12) << channel;
    EXPECT_NEAR(x, 0.0, 6e-11) << channel;
  }
  // Alone, where nothing comes after their end, they stop in the middle.
  EXPECT_GT(std::abs(integral(*from(white, rate), 0, rate).first), 1e-4);
  EXPECT_EQ(from(white, rate)->n_samples(), 1800);
}

TEST(SumFloor, AMultisineThatEndsEarlyIsRefused) {
  const std::string multisine =
      "multisine: {frequencies_hz: [1], amplitude: 1, ramp_s: 1, window_s: 4}";
  EXPECT_EQ(
      message_of<InputError>(
          [&] { from("sum: [{" + multisine + "}, {still: {duration_s: 60}}]"); }),
      "floor.yaml:1:7: sum[1]: ends in the middle of its motion before the others of the sum; "
      "allowed is a multisine that lasts longest");
  EXPECT_EQ(from("sum: [{" + multisine + "}, {still: {duration_s: 1}}]")->n_samples(), 15000);
}

TEST(RecordedRotations, MoveTheFloorAboutTheirPoint) {
  const ScratchFolder folder;
  std::string text = "# fs_hz=50 n=301 units=rad/s^2\na\n";
  for (int k = 0; k < 301; ++k) text += std::to_string(std::sin(0.1 * k * k)) + "\n";
  const auto csv = folder.write("a.csv", text);
  const auto source =
      from("recording: {file: '" + csv.string() + "', axes: {a: rz}, about: [1, 2, 3]}", 50.0);
  ASSERT_EQ(source->meaning(), FloorChannels::rigid);
  const Eigen::VectorXd w = at(*source, 100);
  EXPECT_NE(w(5), 0.0);
  // -theta x p with theta along z: (theta p_y, -theta p_x, 0).
  EXPECT_NEAR(w(0), 2 * w(5), 1e-15);
  EXPECT_NEAR(w(1), -w(5), 1e-15);
  EXPECT_EQ(w(2), 0.0);
  EXPECT_NE(message_of<InputError>([&] {
              from("recording: {file: '" + csv.string() + "', axes: {a: z}}", 50.0);
            }).find("units: found 'rad/s^2', allowed is m/s^2"),
            std::string::npos);
}

}  // namespace
}  // namespace stillframe::floor

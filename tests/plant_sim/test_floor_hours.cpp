#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/high_pass.hpp"
#include "plant_sim/floor_motion.hpp"

// Ten hours of floor: what the held accelerations integrate to stays bounded, where it must end it
// ends, and the plant's integral is that of the samples, to the last digits.
namespace stillframe {
namespace {

const char* const one_node = R"(
title: A mass on a shaking table
nodes:
  table: {position: [0, 0, 0]}
  mass: {position: [0, 0, 0.1]}
masses:
  - {node: mass, mass: 10}
elements:
  leg: {type: truss, nodes: [table, mass], stiffness: 4e5}
supports:
  - {nodes: [table, mass], fix: [x, y]}
prescribed:
  - {nodes: [table], move: [z]}
dofs:
  - {element: leg}
inputs:
  - {name: table, acceleration: table, along: z}
)";

struct Hours {
  double largest = 0;          ///< m, of the position anywhere
  double position, velocity;   ///< m, m/s at the end
  double deviation = 0;        ///< m, largest difference from sums in long double
  double plain_deviation = 0;  ///< m, of sums in double
};

/// Moves on through the whole floor, in parts as a plant under a delayed command does.
Hours through(const std::string& block, double rate) {
  const Scene scene = parse_scene(one_node, "scene.yaml");
  const Model model = make_model(scene);
  const auto spec = floor::read_floor_block(YamlReader::from_text(block, "floor.yaml"), rate,
                                            std::vector<std::string>{"table"});
  FloorMotion floor(floor::make_floor_source(spec), scene, model);
  const double T = 1.0 / rate, first = 0.25 * T, second = 0.75 * T;
  long double x = 0, v = 0;
  double plain_x = 0, plain_v = 0;
  Eigen::VectorXd q_r(1), q_r_dot(1);
  Hours hours;
  for (std::int64_t k = 0; k < floor.n_samples(); ++k) {
    floor.take(k);
    const double a = floor.floor_acceleration()(0);
    for (const double part : {first, second}) {
      floor.finish(part);
      const long double t = part;
      x += t * (v + t * a / 2);
      v += t * a;
      plain_x += part * (plain_v + 0.5 * part * a);
      plain_v += part * a;
    }
    if (k % 64 == 0 || k + 1 == floor.n_samples()) {
      floor.floor_at(0.0, q_r, q_r_dot);
      hours.largest = worst_of(hours.largest, std::abs(q_r(0)));
      hours.deviation = worst_of(hours.deviation, static_cast<double>(std::abs(q_r(0) - x)));
      hours.plain_deviation =
          worst_of(hours.plain_deviation, static_cast<double>(std::abs(plain_x - x)));
    }
  }
  hours.position = q_r(0);
  hours.velocity = q_r_dot(0);
  std::printf(
      "largest %.3g m, at the end %.3g m, %.3g m/s; against long double %.3g m, plain %.3g m\n",
      hours.largest, hours.position, hours.velocity, hours.deviation, hours.plain_deviation);
  return hours;
}

TEST(TenHours, OfNoiseEndAtRestWhereTheyBegan) {
  const Hours hours = through("noise: {vc: C, duration_s: 36000, axes: [z]}", 500.0);
  // VC-C is 12.5 um/s in each band: 13 um rms of displacement in all, some ten times that never.
  EXPECT_GT(hours.largest, 5e-6);
  EXPECT_LT(hours.largest, 1e-4);
  // 5e5 accelerations of some 5 mm/s^2 are rounded by 3e-19 m/s^2 each, and the noise repeats after
  // them, so that what they leave, root 5e5 of T of it, comes 36 times alike: 1.5e-17 m/s, which
  // grows to half of it times 3.6e4 s of way, 2.8e-13 m. Four standard deviations of that.
  EXPECT_NEAR(hours.position, 0.0, 1.1e-12);
  EXPECT_NEAR(hours.velocity, 0.0, 6e-17);
  // Long double sums round by 5e-20 of 1e-4 m/s in velocity: root n of that over 3.6e4 s, 8e-16 m.
  EXPECT_LT(hours.deviation, 5e-15);
}

TEST(TenHours, OfARecordingWithOffsetAndDriftStayBounded) {
  const double rate = 100.0, recorded_rate = 10.0, corner = 0.1;
  const int n = 360001;
  const auto csv = std::filesystem::path(::testing::TempDir()) / "stillframe_ten_hours.csv";
  {
    std::ofstream file(csv);
    file << "# fs_hz=10 n=" << n << " units=m/s^2\na\n";
    for (int k = 0; k < n; ++k) {
      // An offset, a drift over the day, the tide, microseism and a hum.
      const double t = k / recorded_rate;
      file << 0.02 + 1e-6 * t + 1e-3 * std::sin(t / 7000) + 2e-4 * std::sin(1.3 * t) +
                  1e-3 * std::sin(17.1 * t)
           << "\n";
    }
  }
  const Hours hours = through(
      "sum: [{recording: {file: '" + csv.string() + "', axes: {a: z}, high_pass_hz: 0.1}}]", rate);
  std::filesystem::remove(csv);
  // No input of modulus a_max can move the floor further than a_max times the sum of |impulse
  // response| of high-pass and double integrator.
  floor::HighPass filter(corner, rate);
  double x = 0.0, v = 0.0, bound = 0.0;
  const double T = 1.0 / rate;
  for (int k = 0; k < static_cast<int>(160.0 * rate); ++k) {  // poles down to exp(-38)
    const double a = filter.step(k == 0 ? 1.0 : 0.0);
    x += T * v + 0.5 * T * T * a;
    v += T * a;
    bound += std::abs(x);
  }
  EXPECT_LT(hours.largest, bound * 0.0595);  // 0.02 + 0.036 + 0.001 + 0.0012 + taper
  EXPECT_GT(hours.largest, 1e-4);            // the transient of the offset
  // The filter has rung out. Its recursion rounds by 1e-16 of 0.06 m/s^2 in each sample, which a
  // biquad lifts by (rate / (2 pi corner))^2 = 2.5e4 at low frequencies: 1.5e-13 m/s^2 for each of
  // 3.6e6 samples; T^2 n^1.5 / root 3 of that is 6e-8 m.
  EXPECT_NEAR(hours.position, 0.0, 6e-8);
  EXPECT_NEAR(hours.velocity, 0.0, 3e-12);
}

TEST(TenHours, AfterAnEventNothingCreeps) {
  const Hours hours = through(
      "sum: [{impact: {axis: z, peak: 2, width_s: 0.05, at_s: 1}},"
      " {step: {input: table, height: 1e-3, rise_s: 0.2, at_s: 5}},"
      " {sine_sweep: {axis: z, from_hz: 1, to_hz: 100, amplitude: 0.01, sweep_s: 60, at_s: 10}},"
      " {still: {duration_s: 36000}}]",
      500.0);
  EXPECT_GT(hours.largest, 1e-3);
  // 3e4 accelerations of 1 cm/s^2 and 25 of 2 m/s^2 round by 1e-18 and 1e-16: 2e-18 m/s at most,
  // for ten hours.
  EXPECT_NEAR(hours.position, 1e-3, 1e-13);
  EXPECT_NEAR(hours.velocity, 0.0, 2e-18);
}

}  // namespace
}  // namespace stillframe

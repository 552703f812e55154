#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/scenes.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

// The frame has two double modes: turned into any position they stay double, and their shapes stay
// orthonormal.
TEST(RepeatedModes, StayDoubleAndOrthonormalHoweverTheSceneIsTurned) {
  const Eigen::VectorXd expected =
      modes(linearise(make_model(frame_scene()), {}, {})).natural_frequencies_hz;
  double worst = 0, split = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Scene scene = moved(frame_scene(), random_rotation(seed), Eigen::Vector3d(3, -2, 5));
    const LinearModel linear = linearise(make_model(scene), {}, {});
    const Modes found = modes(linear);
    const Eigen::VectorXd& f = found.natural_frequencies_hz;
    worst = worst_of(worst, worst_of((f - expected).cwiseQuotient(expected)));
    split = worst_of({split, std::abs(f(1) / f(0) - 1), std::abs(f(4) / f(3) - 1)});
    const Eigen::MatrixXd VMV = found.shapes.transpose() * linear.M * found.shapes;
    EXPECT_LE(worst_of(VMV - Eigen::MatrixXd::Identity(6, 6)), 1e-13) << seed;
  }
  reached("repeated modes of the turned frame", worst, 12.4);
  // Positions of metres carry 1e-16 m into arms of 0.1 m: 1e-15, a few times over.
  EXPECT_LE(worst, 1e-13);
  EXPECT_LE(split, 1e-13);
}

// Lengths in mm, masses in tonnes, forces in N: frequencies and force to force are the same
// numbers, and the condition of what is solved must not suffer.
TEST(Units, MillimetresAndTonnesGiveTheSameFrequencies) {
  for (const Scene& scene :
       {frame_scene(), by_lens_coordinates(frame_scene()), preloaded_frame()}) {
    const Eigen::VectorXd f = modes(linearise(make_model(scene), {}, {})).natural_frequencies_hz;
    const Eigen::VectorXd f_mm =
        modes(linearise(make_model(in_millimetres(scene)), {}, {})).natural_frequencies_hz;
    const double error = ((f - f_mm).array() / f.array()).abs().maxCoeff();
    reached("millimetres and tonnes against metres and kilograms", error, 1e6);
    EXPECT_LE(error, 1e-12);  // rounding of 28 conditions whose rows differ by 1e3 in size
  }
}

}  // namespace
}  // namespace stillframe::test

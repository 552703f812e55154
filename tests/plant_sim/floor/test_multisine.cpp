#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "core/numerics/low_crest.hpp"
#include "core/numerics/worst.hpp"
#include "core/yaml/reader.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/multisine.hpp"
#include "tests/plant_sim/floor/spectrum.hpp"

namespace stillframe::floor {
namespace {

using testing::blackman_harris;
using testing::line;

constexpr double natural_frequencies_hz[] = {13.9055, 20.0055, 31.3203, 49.0032};

/// The experiment that config/floors/multisine.yaml describes, on six inputs at 1 kHz.
struct MultisineFloor : ::testing::Test {
  static void SetUpTestSuite() {
    const auto reader =
        YamlReader::from_file(STILLFRAME_SOURCE_DIR "/config/floors/multisine.yaml");
    plan = std::get<MultisinePlan>(read_floor_block(reader, 1000.0, 6).kind);
    table = multisine_table(plan);
  }
  static auto window(Eigen::Index channel, Eigen::Index block) {
    return table.row(channel).segment(plan.window_begin(block), plan.window_samples());
  }
  static double line_amplitude() {
    return plan.amplitude * std::sqrt(2.0 / static_cast<double>(plan.frequencies_hz.size()));
  }

  inline static MultisinePlan plan;
  inline static Eigen::MatrixXd table;
};

TEST_F(MultisineFloor, TheShippedLinesKeepClearOfTheNaturalFrequencies) {
  EXPECT_EQ(plan.frequencies_hz.size(), 50u);
  EXPECT_EQ(plan.frequencies_hz.front(), 0.5);
  EXPECT_EQ(plan.frequencies_hz.back(), 200.0);
  for (const double f : plan.frequencies_hz) {
    for (const double natural : natural_frequencies_hz) EXPECT_GE(std::abs(f - natural), 1.0);
  }
}

TEST_F(MultisineFloor, BlocksAreOrthogonalAtEveryLine) {
  ASSERT_EQ(table.rows(), 6);
  ASSERT_EQ(table.cols(), 6 * 16000);
  const double expected = 6.0 * line_amplitude() * line_amplitude();
  for (const double f : plan.frequencies_hz) {
    Eigen::MatrixXcd w(6, 6);
    for (Eigen::Index i = 0; i < 6; ++i) {
      for (Eigen::Index b = 0; b < 6; ++b) {
        w(i, b) = line(window(i, b), f, plan.sample_rate_hz, plan.window_begin(b));
      }
    }
    const Eigen::MatrixXcd gram = w * w.adjoint() - expected * Eigen::MatrixXcd::Identity(6, 6);
    // Lines are whole periods at least 4 bins apart, where the window's transform is exactly zero:
    // only the rounding of a sum of 8000 terms, of 50 lines, is left.
    EXPECT_LT(worst_of(gram), 1e-11 * expected) << f << " Hz";
  }
}

TEST_F(MultisineFloor, PhasorsAreThoseOfTheDefinition) {
  const double f = plan.frequencies_hz[7];
  const auto reference = line(window(0, 0), f, plan.sample_rate_hz, plan.window_begin(0));
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index b = 0; b < 6; ++b) {
      const auto turn = std::polar(1.0, 2.0 * std::numbers::pi * static_cast<double>(i * b) / 6.0);
      const auto found = line(window(i, b), f, plan.sample_rate_hz, plan.window_begin(b));
      EXPECT_LT(std::abs(found - turn * reference), 1e-11 * line_amplitude());  // as above
    }
  }
}

TEST_F(MultisineFloor, RmsIsAsAskedAndTheCrestIsLow) {
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index b = 0; b < 6; ++b) {
      const double rms = std::sqrt(window(i, b).squaredNorm() / 8000.0);
      EXPECT_NEAR(rms, plan.amplitude, 1e-12 * plan.amplitude);  // whole periods: rounding only
      const double crest = worst_of(window(i, b)) / rms;
      // All 43 lines in phase would give sqrt(86) = 9.3, random phases about 3.5, Schroeder's 3.9.
      EXPECT_LT(crest, 2.5) << "input " << i << ", block " << b;
    }
  }
}

TEST_F(MultisineFloor, TheWholeSignalIsQuietAtTheNaturalFrequencies) {
  // The transitions are in the signal. Its window over 72 s separates lines 0.06 Hz apart.
  double quietest_line = 1e9;
  for (const double f : plan.frequencies_hz) {
    for (Eigen::Index i = 0; i < 6; ++i) {
      // An input whose phasor turns by 2 pi i / 6 from block to block may cancel over the whole
      // signal; in a window it never does.
      quietest_line = std::min(quietest_line, std::abs(line(window(i, 2), f, 1000.0)));
    }
  }
  for (const double f : natural_frequencies_hz) {
    for (Eigen::Index i = 0; i < 6; ++i) {
      // Asked are 60 dB. The nearest line is 1 Hz away, the edge of the main lobe of a 4 s glide,
      // beyond which a Blackman-Harris window is 92 dB down: 80 dB leave room for the sum over
      // lines and blocks.
      EXPECT_LT(std::abs(line(table.row(i), f, 1000.0)), 1e-5 * quietest_line) << f << " Hz";
    }
  }
}

TEST_F(MultisineFloor, AnUndampedOscillatorIsLeftWithoutFreeMotion) {
  const double ts = 1.0 / plan.sample_rate_hz;
  for (const double natural : natural_frequencies_hz) {
    // x'' + w^2 x = -a with a held over each sample, solved exactly from sample to sample.
    const double w = 2.0 * std::numbers::pi * natural;
    const double c = std::cos(w * ts), s = std::sin(w * ts);
    double x = 0.0, v = 0.0;
    Eigen::VectorXd motion(table.cols());
    for (Eigen::Index k = 0; k < table.cols(); ++k) {
      motion(k) = x;
      const double rest = -table(1, k) / (w * w);
      const double next = rest + c * (x - rest) + s * v / w;
      v = -w * s * (x - rest) + c * v;
      x = next;
    }
    for (Eigen::Index b = 0; b < 6; ++b) {
      const auto steady = motion.segment(plan.window_begin(b), plan.window_samples());
      double largest = 0.0;
      for (const double f : plan.frequencies_hz) {
        largest = worst_of(largest, std::abs(line(steady, f, plan.sample_rate_hz)));
      }
      // The window over the steady part leaves -92 dB of the lines; the oscillator adds what the
      // glides leak at its frequency, -92 dB again, collected over six transitions. 1e-4 is 80 dB,
      // far below the 0.2 dB (2e-2) that identification may be wrong.
      EXPECT_LT(std::abs(line(steady, natural, plan.sample_rate_hz)), 1e-4 * largest)
          << natural << " Hz, block " << b;
    }
  }
}

TEST_F(MultisineFloor, TheFloorStaysWhereItIs) {
  // Zero frequency is a free mode of the floor: a transition that is not quiet there leaves a
  // velocity behind, and 96 s make a walk of it.
  const double ts = 1.0 / plan.sample_rate_hz;
  double bound = 0.0;
  for (const double f : plan.frequencies_hz) {
    bound += line_amplitude() / std::pow(2.0 * std::numbers::pi * f, 2);
  }
  for (Eigen::Index i = 0; i < 6; ++i) {
    double x = 0.0, v = 0.0, largest = 0.0;
    for (Eigen::Index k = 0; k < table.cols(); ++k) {
      x += ts * v + 0.5 * ts * ts * table(i, k);
      v += ts * table(i, k);
      largest = worst_of(largest, std::abs(x));
    }
    // All lines at their peaks together make the bound; the glide, -92 dB at 0.5 Hz from the
    // nearest line, adds a velocity of 2.5e-5 A / (2 pi 0.5 Hz) at most, over 96 s a hundredth of
    // the bound.
    EXPECT_LT(largest, 1.1 * bound) << "input " << i;
    EXPECT_GT(largest, 0.2 * bound) << "input " << i;
  }
}

TEST(Multisine, TheGlideIsTheIntegralOfItsWindow) {
  EXPECT_EQ(glide(-1.0), 0.0);
  EXPECT_EQ(glide(0.0), 0.0);
  EXPECT_EQ(glide(1.0), 1.0);
  EXPECT_EQ(glide(2.0), 1.0);
  const int n = 1000;
  const Eigen::VectorXd window = blackman_harris(n);
  for (int k = 1; k < n; ++k) {
    // The central difference of step h = 1e-3 is off by h^2 / 24 times the window's second
    // derivative, at most (1.36 + 4 * 0.39 + 9 * 0.03) (2 pi)^2 = 126: 5e-6.
    const double slope = (glide((k + 0.5) / n) - glide((k - 0.5) / n)) * n;
    EXPECT_NEAR(slope, window(k), 6e-6);
  }
}

TEST(Multisine, EvenLinesHaveSchroedersPhases) {
  std::vector<double> lines;
  const int n = 32;
  for (int l = 1; l <= n; ++l) lines.push_back(l);
  const Eigen::VectorXd phases = schroeder_phases(lines, 1.0);
  for (int l = 0; l < n; ++l) {
    // Schroeder's -pi l (l + 1) / n for equal lines, l from 0, up to whole turns; rounding of 32
    // sums.
    const double error = phases(l) + std::numbers::pi * l * (l + 1.0) / n;
    EXPECT_NEAR(std::remainder(error, 2.0 * std::numbers::pi), 0.0, 1e-12);
  }
}

TEST(Multisine, ImpossiblePlansAreRefused) {
  MultisinePlan plan{
      .sample_rate_hz = 1000.0, .frequencies_hz = {2.0}, .n_blocks = 2, .amplitude = 1};
  EXPECT_NO_THROW(multisine_table(plan));
  plan.n_blocks = 0;
  EXPECT_THROW(multisine_table(plan), std::invalid_argument);
  plan.n_blocks = 2;
  plan.ramp_s = 1.00001;
  EXPECT_THROW(multisine_table(plan), std::invalid_argument);
  plan.ramp_s = 1.0;
  plan.frequencies_hz.clear();
  EXPECT_THROW(multisine_table(plan), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::floor

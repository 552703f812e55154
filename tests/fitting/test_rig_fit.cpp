#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "core/control/fitting/rig_fit.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/fitting/simulated_record.hpp"
#include "tests/fitting/small_frame.hpp"

namespace stillframe::fitting {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd drawn(Index p, std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(-1, 1);
  VectorXd values(p);
  for (double& value : values) value = part(random);
  return values;
}

Drive drive_of(unsigned seed) {
  return {.n_window = 1000,
          .n_windows = 4,
          .n_rest = 12,
          .lines = {3,  5,  7,  9,  11, 13,  15,  17,  19,  22,  25,  28,  32,  36,  41,  47,
                    54, 62, 71, 82, 94, 108, 124, 142, 163, 187, 215, 247, 284, 326, 375, 420},
          .floor_noise = 0.003,
          .sigma_noise = 0.02,
          .applied_noise = 0.003,
          .frame_noise = 1e-4,
          .seed = seed};
}

/// The 95 % bands of rigs that nobody chose hold what was hidden in 95 of 100, each kind by itself;
/// and where the model can say all that the rig does, noise alone is left.
TEST(RigFit, BandsHoldWhatWasHidden) {
  const FitQuestion question = small_frame_question();
  const auto p = static_cast<Index>(question.parameters.size());
  std::mt19937_64 random(3);
  int n = 0, within = 0;
  double left = 0;
  for (unsigned trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const VectorXd hidden = drawn(p, random);
    const SampledPlant plant = robustness::sampled(
        robustness::perturbed(question.scene, question.sampling, question.parameters, hidden));
    const Simulated rig = simulate(plant, drive_of(trial));
    const RigFit fit = fit_rig(question, rig.record, rig.driven);
    EXPECT_TRUE(fit.converged);
    EXPECT_TRUE(fit.is_noise()) << fit.over_noise;
    left += fit.over_noise / 20;
    for (Index i = 0; i < p; ++i) {
      const double off = std::abs(fit.values(i) - hidden(i)) / fit.deviation(i);
      if (fit.deviation(i) > 0.3) continue;  // known beforehand rather than found
      ++n;
      within += off < 1.96;
    }
  }
  std::cout << within << " of " << n << " within, over noise " << left << "\n";
  EXPECT_GT(within, 0.90 * n);
  EXPECT_LT(within, 0.99 * n);
}

/// Delays of whole numbers of samples, at which what is applied jumps, are found from others and
/// from themselves.
/// A command that acted otherwise than was written down, once: its window is left out, and what is
/// found is what was hidden. In every window it is no accident, and is said.
TEST(RigFit, OneAccidentIsLeftOut) {
  const FitQuestion question = small_frame_question();
  const auto p = static_cast<Index>(question.parameters.size());
  const SampledPlant plant = robustness::sampled({question.scene, question.sampling});
  const Simulated rig = simulate(plant, drive_of(5));
  const auto spoil = [&](RigRecord& record, std::size_t w) {
    record.command.row(record.windows[w] + 300).array() += 3;
  };
  RigRecord once = rig.record, always = rig.record;
  std::size_t n_driven = 0;
  for (std::size_t w = 0; w < rig.driven.size(); ++w) {
    if (!rig.driven[w]) continue;
    if (n_driven++ == 1) spoil(once, w);
    spoil(always, w);
  }
  const RigFit fit = fit_rig(question, once, rig.driven);
  EXPECT_EQ(fit.n_left_out, 1);
  EXPECT_TRUE(fit.is_noise()) << fit.over_noise;
  for (Index i = 0; i < p; ++i) EXPECT_LT(std::abs(fit.values(i)), 5 * fit.deviation(i)) << i;
  const RigFit bad = fit_rig(question, always, rig.driven);
  EXPECT_EQ(bad.n_left_out, 0);
  EXPECT_FALSE(bad.is_noise());
}

TEST(RigFit, WholeDelaysAreFound) {
  for (const double nominal : {0.0, 1.0, 1.3}) {
    for (const double hidden : {0.0, 1.0, 2.0}) {
      SCOPED_TRACE(std::to_string(nominal) + " " + std::to_string(hidden));
      FitQuestion question = small_frame_question();
      question.sampling.delay_samples = hidden;
      const SampledPlant plant = robustness::sampled({question.scene, question.sampling});
      const Simulated rig = simulate(plant, drive_of(7));
      question.sampling.delay_samples = nominal;
      question.parameters.back().size = 1.5;
      ASSERT_EQ(question.parameters.back().kind, robustness::Parameter::Kind::delay);
      const RigFit fit = fit_rig(question, rig.record, rig.driven);
      const auto p = fit.values.size();
      EXPECT_TRUE(fit.converged);
      EXPECT_TRUE(fit.is_noise()) << fit.over_noise;
      EXPECT_NEAR(nominal + 1.5 * fit.values(p - 1), hidden, 5e-3);
      for (Index i = 0; i + 1 < p; ++i) {
        // Twenty parameters of a rig: five standard deviations in none.
        EXPECT_LT(std::abs(fit.values(i)), 5 * fit.deviation(i));
      }
    }
  }
}

}  // namespace
}  // namespace stillframe::fitting

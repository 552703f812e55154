#include <gtest/gtest.h>

#include <random>

#include "core/control/fitting/rig_fit.hpp"
#include "tests/fitting/simulated_record.hpp"
#include "tests/fitting/small_frame.hpp"

namespace stillframe::fitting {
namespace {

/// A plant that is stepped in time obeys the sums of RigModel to rounding: with undamped modes that
/// ring from a step of the drive, delays of parts of samples, late reports, a sensor filter and a
/// lag, and a floor that is measured.
TEST(RigModel, IsWhatAPlantDoesStepByStep) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 6; ++trial) {
    SCOPED_TRACE(trial);
    FitQuestion question = small_frame_question();
    question.sampling.delay_samples = std::uniform_real_distribution<double>(0, 3)(random);
    if (trial % 3 == 0) question.sampling.delay_samples = trial / 3;
    question.sampling.instruments.report_age_samples = trial % 4;
    if (trial % 2 == 1) question.sampling.instruments.actuator_lag_hz = 200;
    if (trial % 5 == 1) question.sampling.instruments.sensor_filter_hz = 300;
    const SampledPlant plant = robustness::sampled({question.scene, question.sampling});
    const Simulated rig = simulate(plant, {.n_window = 400,
                                           .n_windows = 2,
                                           .n_rest = 1,
                                           .lines = {3, 7, 11, 20, 45, 90, 150},
                                           .floor_noise = 0.01,
                                           .seed = static_cast<unsigned>(trial),
                                           .floor_is_measured = true});
    const RigFit fit = fit_rig(question, rig.record, rig.driven);
    // Of sums of 400 numbers that outgrow their lines by a hundred.
    EXPECT_LT(fit.left_before.maxCoeff(), 1e-9);
    // Nothing is to be found, and what knows that is least squares.
    EXPECT_LT(fit.values.lpNorm<Eigen::Infinity>(), 1e-4);
  }
}

}  // namespace
}  // namespace stillframe::fitting

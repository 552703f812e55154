#include <gtest/gtest.h>

#include <random>

#include "report/analysis/response_analyser.hpp"
#include "report/identification/comparison.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rate = 500;

/// The toy frame in closed loop on a floor of white noise, identified about its own model between
/// channels that are to be that floor and its outputs.
class AboutTheModel : public ::testing::Test {
 protected:
  AboutTheModel() {
    record_ = toy::simulate(loop_, noise(20000), VectorXd::Zero(loop_.A.rows()));
    for (const double f : plan_.frequencies_hz) model_.push_back(transfer(loop_, 2 * toy::pi * f));
  }

  MatrixXd noise(Index n) {
    return 1e-3 * MatrixXd::NullaryExpr(n, 3, [this] { return normal_(random_); });
  }
  /// The model is right: it makes the outputs of the floor that it follows.
  IdentifiedResponse identified(const MatrixXd& channels, const MatrixXd& followed) const {
    ResponseAnalyser analyser({{"floor_x", "floor_y", "floor_z"}, {"a", "b", "c"}}, plan_, model_);
    analyser.add(0, channels, record_.outputs, record_.outputs, channels - followed);
    return analyser.finish();
  }

  std::mt19937_64 random_{3};
  std::normal_distribution<double> normal_;
  toy::Frame frame_;
  SampledLoop loop_ = close_loop(sample_and_hold(frame_.plant(), toy::sampled_at(1 / rate, 1)),
                                 frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, 1 / rate));
  BroadbandPlan plan_{.sample_rate_hz = rate,
                      .n_inputs = 3,
                      .n_outputs = 3,
                      .frequencies_hz = {1, 2, 4, 7, 10, 16, 25, 40, 80},
                      .segment_s = 16,
                      .expected_s = 40};
  std::vector<Eigen::MatrixXcd> model_;
  toy::Record record_;
};

TEST_F(AboutTheModel, ChannelsThatAreTheFloorShowIt) {
  const IdentifiedResponse same = identified(record_.inputs, record_.inputs);
  ASSERT_TRUE(same.response.has_value()) << same.missing;
  for (std::size_t l = 0; l < model_.size(); ++l) {
    EXPECT_LE((same.response->T[l] - model_[l]).norm(), 1e-12 * model_[l].norm()) << l;
  }
}

TEST_F(AboutTheModel, AChannelThatIsNotTheFloorIsRefused) {
  for (const double factor : {3.0, -1.0, 0.0, 1.05}) {
    MatrixXd channels = record_.inputs;
    channels.col(2) *= factor;
    if (factor == 0) channels.col(2) = noise(channels.rows()).col(2);
    const IdentifiedResponse other = identified(channels, record_.inputs);
    EXPECT_FALSE(other.response.has_value()) << factor;
    EXPECT_EQ(
        other.missing.find("floor_z is not what the inputs say of a floor that does not turn"), 0u)
        << factor << " " << other.missing;
  }
  MatrixXd channels = record_.inputs;
  channels(9000, 2) = 1e3;  // one sample
  EXPECT_FALSE(identified(channels, record_.inputs).response.has_value());
}

/// What does not show beyond its band is in the bands: half of T here, were it all.
TEST_F(AboutTheModel, NoiseOfAChannelIsInTheBands) {
  const IdentifiedResponse same = identified(record_.inputs, record_.inputs);
  const IdentifiedResponse noisy =
      identified(record_.inputs, record_.inputs + 0.5 * noise(record_.inputs.rows()));
  ASSERT_TRUE(noisy.response.has_value()) << noisy.missing;
  for (Index l = 0; l < noisy.response->n_frequencies(); ++l) {
    const auto at = static_cast<std::size_t>(l);
    // The floor that the model follows has noise of half the floor's size, and so has its answer.
    const double expected = 0.5 * 1e-3 * model_[at].norm();
    const double found = std::sqrt(noisy.response->noise[at].real().trace());
    if (!noisy.response->T[at].allFinite()) continue;
    EXPECT_NEAR(found / expected, 1, 0.5) << l;
    EXPECT_LE(std::sqrt(same.response->noise[at].real().trace()), 1e-12 * expected) << l;
  }
}

/// x and y of the floor hardly differ, and the sensors of the floor have noise: the model follows
/// what they say, the frame what the floor does.
class NoiseOfTheInputs : public AboutTheModel {
 protected:
  /// What is compared of the loop and how far it lies off, where y is x and `apart` of its size.
  /// sensors: size of their noise; known: what is said of it, m/s^2/sqrt(Hz).
  PredictionError compared(double apart, double sensors, std::optional<double> known) {
    MatrixXd floor = noise(n_samples_);
    floor.col(1) = floor.col(0) + apart * floor.col(1);
    const VectorXd rest = VectorXd::Zero(loop_.A.rows());
    const MatrixXd outputs = toy::simulate(loop_, floor, rest).outputs;
    const MatrixXd read = floor + sensors * noise(floor.rows());
    const MatrixXd predicted = gain_ * toy::simulate(loop_, read, rest).outputs;
    const Index n = read.rows();
    plan_.input_noise = known;
    ResponseAnalyser analyser({{"x", "y", "z"}, {"a", "b", "c"}}, plan_, model_);
    // A row of a record holds the input of the row before it in the floor (toy::simulate).
    analyser.add(0, read, outputs.bottomRows(n), predicted.bottomRows(n));
    const IdentifiedResponse found = analyser.finish();
    EXPECT_TRUE(found.response.has_value()) << found.missing;
    if (!found.response) return {};
    return compare(*found.response, singular_value_bands(*found.response, 0.95, 200),
                   singular_values(model_));
  }
  /// One-sided, of noise() in m/s^2/sqrt(Hz).
  static double density(double sensors) { return sensors * 1e-3 / std::sqrt(0.5 * rate); }
  Index n_samples_ = 20000;
  double gain_ = 1;  ///< of the model over what it should be
  Index all() const { return 3 * static_cast<Index>(model_.size()); }
};

TEST_F(NoiseOfTheInputs, IsNoExcitation) {
  // From a hundredth of their difference to thirty times it.
  for (const double sensors : {1e-5, 1e-4, 3e-4, 1e-3, 1e-2, 3e-2}) {
    for (const bool known : {true, false}) {
      const PredictionError error =
          compared(1e-3, sensors, known ? std::optional(density(sensors)) : std::nullopt);
      // The loop is the model's. All values of a record together are outside one time in twenty,
      // and then by little.
      EXPECT_LE(error.beyond_db, error.tolerance_db) << sensors << " " << known;
      if (sensors >= 1e-3) {  // as much as what differs, and more
        EXPECT_EQ(error.n_compared, 0) << sensors << " " << known;
      }
      if (sensors <= 1e-5) {  // a part in ten thousand of its power
        EXPECT_EQ(error.n_compared, all()) << sensors << " " << known;
      }
    }
  }
}

/// What such a record would say of the loop if its sensors were taken at their word.
TEST_F(NoiseOfTheInputs, WouldBeTakenForTheLoop) {
  n_samples_ = 160000;  // noise alone would hide it in less
  plan_.expected_s = 320;
  // A fifth of the power of what differs is noise, and a fifth of T missing: 1.9 dB.
  EXPECT_GT(compared(1e-3, 5e-4, 0.0).beyond_db, 1);
  EXPECT_EQ(compared(1e-3, 5e-4, density(5e-4)).beyond_db, 0);
  EXPECT_EQ(compared(1e-3, 5e-4, std::nullopt).beyond_db, 0);
}

/// Inputs that move independently are known, with a hundredth of their size as noise too.
TEST_F(NoiseOfTheInputs, LeavesWhatIsWellExcited) {
  for (const bool known : {true, false}) {
    const PredictionError error =
        compared(1, 1e-2, known ? std::optional(density(1e-2)) : std::nullopt);
    EXPECT_EQ(error.n_compared, all()) << known;
    EXPECT_LE(error.beyond_db, error.tolerance_db) << known;
  }
}

/// Noise of the outputs is none of the inputs': a loop that is wrong still shows.
TEST_F(NoiseOfTheInputs, DoesNotHideALoopThatIsWrong) {
  gain_ = 1.2;  // 1.6 dB
  for (auto& T : model_) T *= gain_;
  const PredictionError error = compared(1, 1e-2, std::nullopt);
  EXPECT_GT(error.beyond_db, 1);
}

}  // namespace
}  // namespace stillframe::report

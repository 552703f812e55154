#include <gtest/gtest.h>

#include <random>

#include "report/analysis/response_analyser.hpp"
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
    analyser.add(0, channels, record_.outputs, record_.outputs, followed);
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
    EXPECT_EQ(other.missing.find("floor_z is not the motion of the floor's inputs: at "), 0u)
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

}  // namespace
}  // namespace stillframe::report

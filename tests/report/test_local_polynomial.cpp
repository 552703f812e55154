#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "report/identification/confidence.hpp"
#include "report/identification/local_polynomial.hpp"
#include "report/spectra/fourier.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rate = 500;

class Broadband : public ::testing::Test {
 protected:
  toy::Frame frame_;
  SampledPlant plant_ = sample_and_hold(frame_.plant(), toy::sampled_at(1 / rate, 1));
  SampledLoop open_ = open_loop(plant_);
  SampledLoop closed_ =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, 1 / rate));
  BroadbandPlan plan_{.sample_rate_hz = rate,
                      .n_inputs = 3,
                      .n_outputs = 3,
                      .frequencies_hz = {1, 2, 4, 7, 10, 16, 25, 40, 80, 150},
                      .segment_s = 32,
                      .expected_s = 64};

  MatrixXd white(Index n) {
    return 1e-3 * MatrixXd::NullaryExpr(n, 3, [this] { return normal_(random_); });
  }
  FrequencyResponse estimate(const toy::Record& record, LocalPolynomial& estimator) {
    estimator.add(0, record.inputs, record.outputs);
    estimator.finish();
    return estimator.estimate();
  }
  static double largest_error(const FrequencyResponse& response, const SampledLoop& loop) {
    double largest = 0;
    for (std::size_t l = 0; l < response.T.size(); ++l) {
      const MatrixXcd exact = transfer(loop, 2 * toy::pi * response.frequencies_hz[l]);
      // A NaN is no small error.
      const double error = (response.T[l] - exact).norm() / exact.norm();
      largest = error <= largest ? largest : error;
    }
    return largest;
  }

  std::mt19937_64 random_{3};
  std::normal_distribution<double> normal_;
};

TEST_F(Broadband, FindsTheClosedLoop) {
  const auto record = toy::simulate(closed_, white(32000), VectorXd::Zero(closed_.A.rows()));
  LocalPolynomial estimator(plan_);
  const FrequencyResponse response = estimate(record, estimator);
  // What a parabola over half_width leaves of T, whose poles are 3.5 Hz away at the nearest (5 Hz
  // damped by 0.7): a cube of 0.4 / 3.5, some of which the least squares take up.
  EXPECT_LT(estimator.half_width_hz(), 0.4);
  EXPECT_LT(largest_error(response, closed_), 1.5e-3);
  EXPECT_GT(response.coherence.minCoeff(), 1 - 1e-5);
  EXPECT_EQ(estimator.n_segments(), 2);
  EXPECT_EQ(estimator.n_left_out(), 1);
}

TEST_F(Broadband, FreeMotionOfAnUndampedPlantIsATransient) {
  // It rings with ten times the acceleration of the excitation, and nothing ever takes that away.
  VectorXd state = VectorXd::Zero(6);
  state.head(3) = frame_.stiffness().inverse() * (1e-2 * frame_.V.rowwise().sum());
  const auto record = toy::simulate(open_, white(32000), state);
  LocalPolynomial estimator(plan_);
  const FrequencyResponse response = estimate(record, estimator);
  // The poles are 2.1 Hz from a frequency at the nearest: a cube of 0.4 / 2.1.
  EXPECT_LT(largest_error(response, open_), 7e-3);
}

TEST_F(Broadband, FinerSegmentsLeaveLess) {
  // The error of the parabola falls with the cube of its width: 27 for three times the length. The
  // least is asked for.
  const auto record = toy::simulate(closed_, white(96000), VectorXd::Zero(closed_.A.rows()));
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    plan_.segment_s = i == 0 ? 16 : 48;
    plan_.expected_s = plan_.segment_s;  // as many bins of each
    LocalPolynomial estimator(plan_);
    errors[i] = largest_error(estimate(record, estimator), closed_);
  }
  EXPECT_GT(errors[0] / errors[1], 9) << errors[0] << " " << errors[1];
}

TEST_F(Broadband, PartsMakeTheSameBitsAsTheWhole) {
  const auto record = toy::simulate(closed_, white(40000), VectorXd::Zero(closed_.A.rows()));
  LocalPolynomial whole(plan_), parts(plan_);
  const FrequencyResponse a = estimate(record, whole);
  Index begin = 0;
  for (Index n = 1; begin < record.inputs.rows(); n = 3 * n + 1) {
    const Index rows = std::min(n, record.inputs.rows() - begin);
    parts.add(begin, record.inputs.middleRows(begin, rows), record.outputs.middleRows(begin, rows));
    begin += rows;
  }
  parts.finish();
  const FrequencyResponse b = parts.estimate();
  for (std::size_t l = 0; l < a.T.size(); ++l) {
    EXPECT_EQ(a.T[l], b.T[l]);
    EXPECT_EQ(a.noise[l], b.noise[l]);
  }
}

TEST_F(Broadband, IsTheLeastSquaresOfAllEquationsAtOnce) {
  // The same equations by the normal way: one matrix for both segments, transients as unknowns.
  plan_.frequencies_hz = {4};
  auto record = toy::simulate(closed_, white(32000), VectorXd::Zero(closed_.A.rows()));
  for (double& value : record.outputs.reshaped()) value += 1e-4 * normal_(random_);
  LocalPolynomial estimator(plan_);
  const FrequencyResponse response = estimate(record, estimator);
  const Index n = 16000;
  const double width = estimator.half_width_hz(), resolution = rate / static_cast<double>(n);
  std::vector<Eigen::RowVectorXcd> left, right;
  for (Index segment = 0; segment < 2; ++segment) {
    const MatrixXcd W = fourier(record.inputs.middleRows(segment * n, n));
    const MatrixXcd Y = fourier(record.outputs.middleRows(segment * n, n));
    for (Index k = 0; k < W.rows(); ++k) {
      const double x = (static_cast<double>(k) * resolution - 4) / width;
      if (std::abs(x) > 1) continue;
      Eigen::RowVectorXcd row = Eigen::RowVectorXcd::Zero(9 + 6);
      for (Index r = 0; r < 3; ++r) {
        row.segment(3 * r, 3) = std::pow(x, r) * W.row(k);
        row(9 + 3 * segment + r) = std::pow(x, r);
      }
      left.push_back(row);
      right.emplace_back(Y.row(k));
    }
  }
  MatrixXcd A(static_cast<Index>(left.size()), 15), B(A.rows(), 3);
  for (Index i = 0; i < A.rows(); ++i) {
    A.row(i) = left[static_cast<std::size_t>(i)];
    B.row(i) = right[static_cast<std::size_t>(i)];
  }
  const MatrixXcd theta = (A.adjoint() * A).ldlt().solve(A.adjoint() * B);
  const MatrixXcd residual = B - A * theta;
  const double dof = static_cast<double>(A.rows()) - 15;
  EXPECT_EQ(response.dof(0), dof);
  // Normal equations lose twice the digits of the condition, some 10 here.
  EXPECT_LT((response.T[0] - theta.topRows(3).transpose()).norm(), 1e-12);
  const MatrixXcd C = (residual.adjoint() * residual).transpose() / dof / static_cast<double>(n);
  EXPECT_LT((response.noise[0] - C).norm(), 1e-10 * C.norm());
  const MatrixXcd G = (A.adjoint() * A).inverse().topLeftCorner(3, 3) * static_cast<double>(n);
  EXPECT_LT((response.input_weight[0] - G).norm(), 1e-10 * G.norm());
}

TEST_F(Broadband, GapsEndSegmentsAndShortOnesAreFilled) {
  const auto record = toy::simulate(closed_, white(48000), VectorXd::Zero(closed_.A.rows()));
  LocalPolynomial estimator(plan_);
  const auto take = [&](Index first, Index n) {
    estimator.add(first, record.inputs.middleRows(first, n), record.outputs.middleRows(first, n));
  };
  take(0, 16000);
  take(20000, 100);   // too short for anything
  take(21000, 8000);  // one sample lost
  take(29001, 7999);
  estimator.finish();
  EXPECT_EQ(estimator.n_segments(), 2);
  EXPECT_EQ(estimator.n_filled(), 1);
  EXPECT_EQ(estimator.n_left_out(), 100);
  // One sample of white noise put in wrongly: 1 / 16000 of the power of a segment.
  EXPECT_LT(largest_error(estimator.estimate(), closed_), 2e-2);
  EXPECT_GT(estimator.estimate().coherence.minCoeff(), 0.99);
}

TEST_F(Broadband, InputsThatMoveTogetherAreToldByTheirCondition) {
  MatrixXd w = white(32000);
  w.col(2) = w.col(0) - 2 * w.col(1);
  const auto record = toy::simulate(closed_, w, VectorXd::Zero(closed_.A.rows()));
  LocalPolynomial estimator(plan_);
  const FrequencyResponse response = estimate(record, estimator);
  EXPECT_GT(response.input_condition.minCoeff(), 1e8);
  EXPECT_TRUE(std::isnan(response.singular_values(0, 0)));
  EXPECT_EQ(response.dof(0), 0);
}

TEST_F(Broadband, WhereNothingExcitesNothingIsSaid) {
  // White noise behind a low-pass of eight poles at 10 Hz: at 150 Hz 2e-19 of the density is left,
  // 190 dB, and what a rectangular window leaks is far above that.
  MatrixXd w = white(32000);
  const double a = 2 * toy::pi * 10 / rate;
  for (int pole = 0; pole < 8; ++pole) {
    for (Index k = 1; k < w.rows(); ++k) w.row(k) = w.row(k - 1) + a * (w.row(k) - w.row(k - 1));
  }
  const auto record = toy::simulate(closed_, w, VectorXd::Zero(closed_.A.rows()));
  LocalPolynomial estimator(plan_);
  const FrequencyResponse response = estimate(record, estimator);
  EXPECT_TRUE(response.T.back().array().isNaN().all()) << response.T.back();
  EXPECT_EQ(response.dof(9), 0);
  for (std::size_t l = 0; l < 6; ++l) {
    const MatrixXcd exact = transfer(closed_, 2 * toy::pi * response.frequencies_hz[l]);
    EXPECT_LT((response.T[l] - exact).norm(), 1.5e-3 * exact.norm()) << l;
  }
}

/// Samples put in on a line are impulses to inputs and outputs, of all frequencies alike.
TEST_F(Broadband, LostSamplesExciteNothing) {
  // As above but for five poles: enough is left at 150 Hz for the whole record to know T there.
  MatrixXd w = white(32000);
  const double a = 2 * toy::pi * 10 / rate;
  for (int pole = 0; pole < 5; ++pole) {
    for (Index k = 1; k < w.rows(); ++k) w.row(k) = w.row(k - 1) + a * (w.row(k) - w.row(k - 1));
  }
  const auto record = toy::simulate(closed_, w, VectorXd::Zero(closed_.A.rows()));
  std::bernoulli_distribution one_in_a_hundred(0.01);
  const std::function<bool(Index)> of_whole = [](Index) { return false; };
  const std::function<bool(Index)> one = [](Index k) { return k == 9001; };
  const std::function<bool(Index)> some = [](Index k) { return k % 3000 == 1500; };
  const std::function<bool(Index)> many = [&](Index) { return one_in_a_hundred(random_); };
  std::vector<int> n_known;
  for (const auto* lost : {&of_whole, &one, &some, &many}) {
    LocalPolynomial estimator(plan_);
    for (Index k = 0; k < record.inputs.rows(); ++k) {
      if ((*lost)(k)) continue;
      estimator.add(k, record.inputs.row(k), record.outputs.row(k));
    }
    estimator.finish();
    const FrequencyResponse response = estimator.estimate();
    n_known.push_back(0);
    for (Index l = 0; l < response.n_frequencies(); ++l) {
      const auto at = static_cast<std::size_t>(l);
      if (response.dof(l) == 0) continue;
      ++n_known.back();
      const MatrixXcd exact = transfer(closed_, 2 * toy::pi * response.frequencies_hz[at]);
      // 9 entries of 10 frequencies: circles of 99.99 % hold nearly all of them together; 1.5e-3 is
      // what a parabola leaves (FindsTheClosedLoop), largest_filling_share what lost samples may.
      const MatrixXd allowed = entry_radii(response, l, 0.9999).array() +
                               (1.5e-3 + largest_filling_share) * exact.norm();
      EXPECT_LE(((response.T[at] - exact).cwiseAbs() - allowed).maxCoeff(), 0)
          << estimator.n_filled() << " lost, " << response.frequencies_hz[at] << " Hz";
    }
    EXPECT_EQ(estimator.missing({"x", "y", "z"}), "");
  }
  EXPECT_EQ(n_known[0], 10);
  EXPECT_EQ(n_known[1], 9);  // nothing tells the impulse from the floor at 150 Hz
  // Up to 10 Hz, where the floor moves, 1 % that is lost takes nothing away.
  EXPECT_GE(n_known[3], 5);
}

TEST_F(Broadband, ARecordThatWasCutOffHasWiderBins) {
  const auto record = toy::simulate(closed_, white(8000), VectorXd::Zero(closed_.A.rows()));
  plan_.expected_s = 3600;
  LocalPolynomial estimator(plan_);
  const double wanted = estimator.half_width_hz();
  const FrequencyResponse response = estimate(record, estimator);
  EXPECT_EQ(estimator.n_segments(), 1);
  EXPECT_GT(estimator.half_width_hz(), 3 * wanted);
  // A parabola over 0.8 Hz: sixteen times (test FindsTheClosedLoop has 0.4 Hz) by its fourth power.
  EXPECT_LT(largest_error(response, closed_), 2.5e-2);
  EXPECT_GE(response.dof.minCoeff(), 12);
}

TEST_F(Broadband, TooShortARecordGivesNoNumbers) {
  LocalPolynomial estimator(plan_);
  const MatrixXd w = white(50);
  estimator.add(0, w, w);
  estimator.finish();
  EXPECT_EQ(estimator.n_segments(), 0);
  EXPECT_EQ(estimator.n_left_out(), 50);
  EXPECT_TRUE(std::isnan(estimator.estimate().singular_values(0, 0)));
}

TEST(Fourier, IsTheSum) {
  for (const Index n : {1, 2, 7, 12, 15, 22}) {
    const MatrixXd x = MatrixXd::Random(n, 3);
    const MatrixXcd X = fourier(x);
    ASSERT_EQ(X.rows(), n / 2 + 1);
    for (Index k = 0; k < X.rows(); ++k) {
      Eigen::RowVectorXcd sum = Eigen::RowVectorXcd::Zero(3);
      for (Index i = 0; i < n; ++i) {
        sum += x.row(i) *
               std::polar(1.0, -2 * toy::pi * static_cast<double>(k * i) / static_cast<double>(n));
      }
      EXPECT_LT((X.row(k) - sum).norm(), 1e-14 * static_cast<double>(n)) << n << " " << k;
    }
  }
}

/// Against a list made by multiplying.
TEST(Fourier, FastLengthsAreProductsOf2And3And5) {
  std::vector<bool> smooth(2001);
  for (int a = 1; a <= 2000; a *= 2) {
    for (int b = a; b <= 2000; b *= 3) {
      for (int c = b; c <= 2000; c *= 5) smooth[static_cast<std::size_t>(c)] = true;
    }
  }
  Index newest = 1;
  for (Index n = 1; n <= 2000; ++n) {
    if (smooth[static_cast<std::size_t>(n)]) newest = n;
    EXPECT_EQ(fast_length(n), newest);
  }
  EXPECT_EQ(fast_length(16000), 16000);  // 16 s at 1 kHz is whole
}

TEST(Fourier, FastLengthsHaveSmallFactorsOnly) {
  EXPECT_EQ(fast_length(60000), 60000);
  EXPECT_EQ(fast_length(60001), 60000);
  EXPECT_EQ(fast_length(7), 6);
  EXPECT_EQ(fast_length(1), 1);
  EXPECT_EQ(fast_length(0), 0);
}

}  // namespace
}  // namespace stillframe::report

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "core/control/robustness/draws.hpp"
#include "core/control/robustness/monte_carlo.hpp"
#include "core/control/robustness/parallel.hpp"
#include "core/numerics/worst.hpp"
#include "tests/robustness/frame.hpp"

namespace stillframe::robustness {
namespace {

SceneUncertainty of_cart() {
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.3;
  uncertainty.mass = 0.3;
  uncertainty.actuator_gain = 0.9;
  return uncertainty;
}

TEST(MonteCarlo, CountsWhatTheClosedFormSays) {
  // u = -kappa sigma damps, as it comes late, and is unstable once the actuator's feedthrough to
  // its own sensor, kappa g, is about 1.
  const Cart cart{.m = 2, .k = 800, .kappa = 0.8, .sample_time = 0.01};
  const Evaluator evaluator = cart.evaluator(of_cart());
  constexpr std::uint64_t n = 300;
  const Tally tally = run_samples(evaluator, {.seed = 9, .samples = n, .shard = {}}, 2);
  std::uint64_t n_stable = 0, worst = 0;
  double largest = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const Eigen::VectorXd values = sample(9, i, 3);
    Cart other = cart;
    other.k *= 1 + 0.3 * values(0);
    other.m *= 1 + 0.3 * values(1);
    const double radius = other.radius(1 + 0.9 * values(2));
    n_stable += radius < largest_stable_radius ? 1 : 0;
    if (radius > largest) worst = i;
    largest = worst_of(largest, radius);
  }
  EXPECT_GT(n_stable, n / 10);
  EXPECT_LT(n_stable, n - n / 10);
  EXPECT_EQ(tally.n_stable, n_stable);
  EXPECT_EQ(tally.n_samples(), n);
  EXPECT_NEAR(tally.radius.most, largest, 1e-11);  // as in test_evaluator.cpp
  EXPECT_EQ(tally.worst[0][0].index, worst);
  EXPECT_EQ(tally.worst[0][0].values, sample(9, worst, 3));
}

TEST(MonteCarlo, ShardsTakeEverySampleOnce) {
  for (const std::uint64_t n : {0, 1, 5, 7, 100}) {
    std::uint64_t sum = 0;
    for (std::uint64_t number = 1; number <= 7; ++number) {
      std::uint64_t count = 0;
      for (std::uint64_t i = number - 1; i < n; i += 7) ++count;
      EXPECT_EQ((Shard{number, 7}.size(n)), count) << n << " " << number;
      sum += count;
    }
    EXPECT_EQ(sum, n);
  }
}

TEST(MonteCarlo, ProgressReachesTheEnd) {
  const Evaluator evaluator = Cart{}.evaluator(of_cart());
  std::atomic<std::uint64_t> calls{0};
  run_samples(evaluator, {.seed = 1, .samples = 25, .shard = {.number = 2, .of = 4}}, 2,
              [&](std::uint64_t done) {
                ++calls;
                EXPECT_LE(done, 6u);
              });
  EXPECT_EQ(calls, 6u);  // 1, 5, 9, ... 21
}

TEST(ParallelFor, EveryIndexOnceAndErrorsComeOut) {
  for (const int jobs : {1, 2, 5}) {
    std::vector<std::atomic<int>> counts(100);
    parallel_for(100, jobs, [&](std::uint64_t i, int job) {
      EXPECT_LT(job, jobs);
      ++counts[i];
    });
    for (const auto& count : counts) EXPECT_EQ(count, 1);
    EXPECT_THROW(parallel_for(100, jobs,
                              [](std::uint64_t i, int) {
                                if (i == 50) throw std::runtime_error("fifty");
                              }),
                 std::runtime_error);
  }
}

double binomial_tail(int k, int n, double x) {
  double sum = 0, choose = 1;
  for (int j = 0; j <= k; ++j) {
    sum += choose * std::pow(x, j) * std::pow(1 - x, n - j);
    choose *= static_cast<double>(n - j) / (j + 1);
  }
  return sum;
}

TEST(UpperBound, ClopperPearson) {
  // Closed forms: (1 - x)^n = 0.05 for none, 1 - x^n = 0.05 for all but one.
  EXPECT_NEAR(upper_bound_of_share(0, 10), 1 - std::pow(0.05, 0.1), 1e-15);
  EXPECT_NEAR(upper_bound_of_share(9, 10), std::pow(0.95, 0.1), 1e-13);
  EXPECT_EQ(upper_bound_of_share(10, 10), 1);
  EXPECT_EQ(upper_bound_of_share(0, 0), 1);
  // The rule of three, -ln(0.05) / n.
  EXPECT_NEAR(upper_bound_of_share(0, 1000000), 2.9957e-6, 1e-10);
  for (const int k : {1, 3, 17, 40, 49}) {
    const double x = upper_bound_of_share(static_cast<std::uint64_t>(k), 50);
    // The slope of the tail is at most about 50; bisection ends at 1e-15.
    EXPECT_NEAR(binomial_tail(k, 50, x), 0.05, 1e-12) << k;
  }
  // Large n: k + 1.645 sqrt(k) and a little more, Poisson's bound being 1e5 + 521.5.
  EXPECT_NEAR(upper_bound_of_share(100000, 100000000), 1.00522e-3, 2e-8);
}

}  // namespace
}  // namespace stillframe::robustness

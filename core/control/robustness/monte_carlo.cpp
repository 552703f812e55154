#include "core/control/robustness/monte_carlo.hpp"

#include <cmath>

#include "core/control/robustness/draws.hpp"
#include "core/control/robustness/parallel.hpp"

namespace stillframe::robustness {

Tally run_samples(const Evaluator& evaluator, const SamplePlan& plan, int jobs,
                  const Progress& progress) {
  const auto n_frequencies = static_cast<size_t>(evaluator.frequencies_hz().size());
  std::vector<Tally> tallies(static_cast<size_t>(std::max(jobs, 1)), Tally(n_frequencies));
  std::atomic<std::uint64_t> done{0};
  parallel_for(plan.shard.size(plan.samples), jobs, [&](std::uint64_t i, int job) {
    const std::uint64_t index = plan.shard.number - 1 + i * plan.shard.of;
    const Eigen::VectorXd values = sample(plan.seed, index, evaluator.size());
    tallies[static_cast<size_t>(job)].add(index, values, evaluator(values));
    ++done;
    if (progress) progress(done);
  });
  for (size_t job = 1; job < tallies.size(); ++job) tallies.front().merge(tallies[job]);
  return tallies.front();
}

namespace {

/// P(X <= k) of a binomial X of n trials with probability x, 0 < x < 1, by summation from the
/// largest term downwards.
double binomial_tail(std::uint64_t k, std::uint64_t n, double x) {
  const auto count = static_cast<double>(n), most = static_cast<double>(k);
  // Terms rise up to the mode; below a bound k above it the sum is all but 1 and ends anyhow.
  double log_term = std::lgamma(count + 1) - std::lgamma(most + 1) - std::lgamma(count - most + 1) +
                    most * std::log(x) + (count - most) * std::log1p(-x);
  double sum = 0;
  for (double j = most; j >= 0; --j) {
    const double term = std::exp(log_term);
    sum += term;
    if (j < count * x && term < 1e-17 * sum) break;
    log_term += std::log(j * (1 - x)) - std::log((count - j + 1) * x);
  }
  return sum;
}

}  // namespace

double upper_bound_of_share(std::uint64_t k, std::uint64_t n) {
  if (k >= n) return 1;
  constexpr double doubt = 0.05;
  if (k == 0) return -std::expm1(std::log(doubt) / static_cast<double>(n));
  double below = static_cast<double>(k) / static_cast<double>(n), above = 1;
  for (int step = 0; step < 200 && above - below > 1e-15 * above; ++step) {
    const double middle = (below + above) / 2;
    (binomial_tail(k, n, middle) > doubt ? below : above) = middle;
  }
  return above;
}

}  // namespace stillframe::robustness

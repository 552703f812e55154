#pragma once

#include <cstdint>
#include <functional>

#include "core/control/robustness/tally.hpp"

namespace stillframe::robustness {

/// Part `number` (from 1) of `of` parts of a set of samples: those whose index leaves number - 1
/// when divided by `of`.
struct Shard {
  std::uint64_t number = 1, of = 1;

  /// How many of n samples these are.
  std::uint64_t size(std::uint64_t n) const { return (n + of - number) / of; }
};

/// Samples 0 to n - 1 of a seed, as draws.hpp makes them.
struct SamplePlan {
  std::uint64_t seed = 1, samples = 0;
  Shard shard;
};

/// Called with the number of evaluations that are done, from any thread.
using Progress = std::function<void(std::uint64_t done)>;

/// Evaluates the samples of a shard on up to `jobs` threads. The same tally, to the last bit, for
/// any number of threads. Set-up.
Tally run_samples(const Evaluator& evaluator, const SamplePlan& plan, int jobs,
                  const Progress& progress = {});

/// The share of all plants, in per unit, below which the share of bad ones is with a confidence of
/// 95 %, after k bad ones among n independent samples: the x with P(at most k bad ones | x) = 5 %;
/// 1 if n = 0 or k = n. Source: Clopper and Pearson, Biometrika 26 (1934) 404-413, one-sided.
double upper_bound_of_share(std::uint64_t k, std::uint64_t n);

}  // namespace stillframe::robustness

#include "core/control/robustness/worst_case.hpp"

#include <atomic>

#include "core/control/robustness/parallel.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe::robustness {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Evaluates, counts, and asks for no more than the measure needs.
class Score {
 public:
  Score(const Evaluator& evaluator, Measure measure, const Progress& progress)
      : evaluator_(evaluator), measure_(measure), progress_(progress) {}

  double operator()(const VectorXd& values) {
    const std::uint64_t done = ++count_;
    if (progress_) progress_(done);
    const auto want = measure_ == Measure::peak ? Evaluator::Want::poles_and_gain  //
                                                : Evaluator::Want::poles;
    return badness(evaluator_(values, want), measure_);
  }
  std::uint64_t count() const { return count_; }

 private:
  const Evaluator& evaluator_;
  Measure measure_;
  const Progress& progress_;
  std::atomic<std::uint64_t> count_{0};
};

VectorXd nearest_corner(const VectorXd& values) {
  return values.unaryExpr([](double value) { return value < 0 ? -1.0 : 1.0; });
}

struct Found {
  VectorXd values;
  double score = 0;
};

/// The signs of the slopes at the nominal plant.
VectorXd slope_corner(Score& score, Index p, int jobs) {
  constexpr double step = 0.1;  // of the box: beyond rounding, within what is about linear
  VectorXd slopes(p);
  parallel_for(static_cast<std::uint64_t>(p), jobs, [&](std::uint64_t i, int) {
    VectorXd values = VectorXd::Zero(p);
    const auto j = static_cast<Index>(i);
    values(j) = step;
    const double above = score(values);
    values(j) = -step;
    slopes(j) = above - score(values);
  });
  return nearest_corner(slopes);
}

constexpr double unsurpassed = infinity;

Found climb(Score& score, VectorXd corner) {
  double best = score(corner);
  Index since_change = 0;
  for (Index j = 0; since_change < corner.size() && best < unsurpassed;
       j = (j + 1) % corner.size()) {
    corner(j) = -corner(j);
    const double flipped = score(corner);
    if (flipped > best) {
      best = flipped;
      since_change = 0;
    } else {
      corner(j) = -corner(j);
      ++since_change;
    }
  }
  return {corner, best};
}

/// The first way from stable to unstable that bisection meets between the nominal plant and values.
double stable_part(const Evaluator& evaluator, const VectorXd& values) {
  double stable = 0, unstable = 1;
  while (unstable - stable > 1e-4) {
    const double middle = (stable + unstable) / 2;
    const Outcome outcome = evaluator(middle * values, Evaluator::Want::poles);
    (outcome.verdict == Outcome::Verdict::stable ? stable : unstable) = middle;
  }
  return stable;
}

/// Adds what explains the worst case.
void explain(const Evaluator& evaluator, WorstCase& worst) {
  worst.outcome = evaluator(worst.values);
  if (worst.outcome.verdict != Outcome::Verdict::stable) {
    worst.stable_part = stable_part(evaluator, worst.values);
  }
  const auto& parameters = evaluator.parameters();
  for (const Parameter& parameter : parameters) {
    if (worst.without.contains(parameter.kind)) continue;
    VectorXd values = worst.values;
    for (size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].kind == parameter.kind) values(static_cast<Index>(i)) = 0;
    }
    worst.without[parameter.kind] = evaluator(values);
  }
}

}  // namespace

WorstCase search_worst(const Evaluator& evaluator, Measure measure,
                       const std::vector<VectorXd>& starts, int jobs, const Progress& progress) {
  Score score(evaluator, measure, progress);
  std::vector<VectorXd> corners{slope_corner(score, evaluator.size(), jobs)};
  for (const VectorXd& start : starts) {
    const VectorXd corner = nearest_corner(start);
    if (std::find(corners.begin(), corners.end(), corner) == corners.end()) {
      corners.push_back(corner);
    }
  }
  const size_t n_climbs = corners.size();
  std::vector<Found> found(n_climbs + starts.size());
  parallel_for(found.size(), jobs, [&](std::uint64_t i, int) {
    found[i] = i < n_climbs ? climb(score, corners[i])
                            : Found{starts[i - n_climbs], score(starts[i - n_climbs])};
  });
  const auto worst = std::max_element(
      found.begin(), found.end(), [](const Found& a, const Found& b) { return a.score < b.score; });
  WorstCase result;
  result.values = worst->values;
  result.evaluations = score.count();
  explain(evaluator, result);
  return result;
}

}  // namespace stillframe::robustness

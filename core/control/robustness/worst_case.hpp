#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/control/robustness/monte_carlo.hpp"

namespace stillframe::robustness {

/// The worst plant of the box [-1, 1]^p that a search has found. There may be a worse one.
struct WorstCase {
  Eigen::VectorXd values;  ///< p
  Outcome outcome;
  /// Part of these values up to which the loop is stable, to 1e-4; 1 if it is so at all of them.
  double stable_part = 1;
  /// What becomes of it with all parameters of one kind at 0, for each kind that there is.
  std::map<Parameter::Kind, Outcome> without;
  std::uint64_t evaluations = 0;
};

/// Searches the corners of the box: from the corner that the slopes at the nominal plant point to,
/// and from the corners next to the given starts, one parameter after the other is flipped as long
/// as that makes things worse. The starts themselves compete with what is found. The same answer
/// for any number of threads. Set-up. Errors: as Evaluator.
WorstCase search_worst(const Evaluator& evaluator, Measure measure,
                       const std::vector<Eigen::VectorXd>& starts, int jobs,
                       const Progress& progress = {});

}  // namespace stillframe::robustness

#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/control/robustness/record.hpp"

namespace stillframe::tools {

/// The spread of T over the sampled plants as curves. Where a resonance of any of them lies nearer
/// to one of the record's frequencies than to its neighbours, the curve is level over all that is
/// nearer to it: the resonance of one plant is here, that of another there, and all are as high.
class Spread {
 public:
  explicit Spread(const robustness::Record& record);

  /// The ends of what is level, and the frequencies between, Hz, ascending.
  const std::vector<double>& nodes_hz() const { return nodes_hz_; }
  /// At frequencies (Hz): what 5 % and 95 % of the plants do not exceed, and the largest of all.
  Eigen::VectorXd low(const Eigen::VectorXd& frequencies_hz) const;
  Eigen::VectorXd high(const Eigen::VectorXd& frequencies_hz) const;
  Eigen::VectorXd most(const Eigen::VectorXd& frequencies_hz) const;

 private:
  Eigen::VectorXd along(const Eigen::VectorXd& frequencies_hz,
                        const std::vector<double>& values_db) const;
  std::vector<double> nodes_hz_, low_db_, high_db_, most_db_;
};

/// The frequencies at which curves of some plants and a spread are drawn: those that show the
/// resonances of each, and the spread's.
Eigen::VectorXd frequencies_of(const robustness::Evaluator& evaluator,
                               const std::vector<Eigen::VectorXd>& plants, const Spread& spread);

/// A histogram of the least damping ratio, in bars of a width that the data ask for: about thirty
/// from the least to the most, and none narrower than what is kept of the samples.
struct DampingBars {
  double width = 0;
  std::map<double, double> shares;  ///< of all samples, by the lower end of the bar
};
DampingBars damping_bars(const robustness::Tally& tally, double nominal);

}  // namespace stillframe::tools

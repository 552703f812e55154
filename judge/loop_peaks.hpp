#pragma once

#include <optional>
#include <vector>

#include "core/systems/resonances.hpp"
#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// The largest singular values from floor to frame whose resonances pictures and tables show.
/// Without a controller there is an open one alone, of the system that is not sampled.
struct LoopGains {
  LargestGain open;                       ///< of the frame left alone, sampled as the loop is
  std::optional<LargestGain> closed;      ///< of the loop that runs
  std::optional<LargestGain> continuous;  ///< of its law without sampling, delay and instruments
};

LoopGains gains_of(const LoopDesign& design);

/// A row that a table needs for a peak between its own.
struct PeakRow {
  enum class Of { open, closed, continuous };
  Peak peak;
  Of of = Of::open;
};
const char* name_of(PeakRow::Of of);

/// The rows that a table with rows at frequencies_hz (ascending) needs beside them, ascending, as
/// peaks_between; of what is sampled up to half its rate.
std::vector<PeakRow> peak_rows(const Eigen::VectorXd& frequencies_hz, LoopGains& gains,
                               double sample_rate_hz);

/// A grid with the points that show the resonances of every curve.
Eigen::VectorXd with_resonances_of(const LoopGains& gains, const Eigen::VectorXd& frequencies_hz);

/// What a picture of a loop's singular values is drawn at.
std::vector<double> picture_frequencies(const LoopDesign& design, const FrequencyRange& range);

}  // namespace stillframe::judge

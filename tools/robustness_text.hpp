#pragma once

#include <string>
#include <vector>

#include "core/control/robustness/record.hpp"
#include "core/control/robustness/worst_case.hpp"

namespace stillframe::tools {

/// What a record says, as a page: counts, spread of T over frequency, worst samples.
std::string page_of(const robustness::Record& record);

/// A worst case in words: what was found, and every parameter's value there, a line a kind.
std::string page_of(const robustness::WorstCase& worst, robustness::Measure measure,
                    const std::vector<robustness::Parameter>& parameters);

/// The value that a part `share` (0 to 1) of all does not exceed: the middle of its bin, but
/// nothing beyond the extremes of the same values; NaN if there are none.
double quantile_within(const robustness::Histogram& histogram, const robustness::Extremes& extremes,
                       double share);
double quantile_within(const robustness::RatioHistogram& histogram,
                       const robustness::Extremes& extremes, double share);
/// The same extremes in dB.
robustness::Extremes in_decibels(const robustness::Extremes& values);

/// The share of plants in per unit that are unstable or do not exist, and the share that their true
/// share is below with a confidence of 95 %.
struct BadShare {
  double found = 0, below = 0;
};
BadShare bad_share(const robustness::Tally& tally);

}  // namespace stillframe::tools

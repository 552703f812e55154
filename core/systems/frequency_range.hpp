#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe {

/// The next of ..., 1, 2, 5, 10, ... from x > 0 up; one that rounding moved counts as itself.
double rounded_up(double x);

/// Both ends of an axis of frequency, Hz, lowest_hz < highest_hz.
struct FrequencyRange {
  double lowest_hz = 0, highest_hz = 0;
};

/// What an axis of frequency shows where nobody says otherwise: from a tenth of the lowest to four
/// times the highest of the twelve slowest own frequencies and the targets, both outwards to the
/// next of 1, 2, 5, 10, ..., and never above half the rate of the loop that runs. Without anything
/// to go by three decades below half the rate, and without a rate 0.1 to 1000 Hz.
/// own_hz: ascending, as own_frequencies_hz (core/mechanics/own_values.hpp). targets_hz: of the
/// controller, empty without one. sample_rate_hz: 0 where nothing is sampled.
FrequencyRange frequency_range(const Eigen::VectorXd& own_hz, const std::vector<double>& targets_hz,
                               double sample_rate_hz);

/// The numbers 1, 2, 5 times a power of ten in a range, both ends included: the lines of a table.
std::vector<double> round_frequencies(const FrequencyRange& range);

}  // namespace stillframe

#pragma once

#include <cmath>

namespace stillframe {

/// Of a ratio of amplitudes.
inline double decibels(double ratio) { return 20 * std::log10(ratio); }

}  // namespace stillframe

#pragma once

#include "report/page/page_data.hpp"

namespace stillframe::page {

/// A spectrum that looks the same and is smaller: of each of n_steps equal steps of log f the
/// smallest and the largest value, in the order of their frequencies; the spectrum itself where
/// that is no longer. Frequencies that are not positive are left out. n_steps: positive.
Curve thin_spectrum(const Curve& spectrum, std::size_t n_steps);

/// A curve that only rises, at most one point in each of n_steps equal steps of log f: the last.
Curve thin_cumulative(const Curve& curve, std::size_t n_steps);

}  // namespace stillframe::page

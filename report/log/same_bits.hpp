#pragma once

#include <cstring>
#include <vector>

namespace stillframe::report {

/// Whether values begins with the very bits of others.
inline bool same_bits(const double* values, const std::vector<double>& others) {
  return others.empty() || std::memcmp(values, others.data(), others.size() * sizeof(double)) == 0;
}

}  // namespace stillframe::report

#pragma once

#include <limits>

namespace stillframe {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace stillframe

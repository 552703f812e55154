#pragma once

#include <Eigen/Core>
#include <cmath>

namespace stillframe {

/// Matrices that go through a computation at once, one in each lane of a vector register.
inline constexpr Eigen::Index lanes = 4;

using Lanes [[gnu::vector_size(lanes * sizeof(double))]] = double;

/// A number a lane, aligned for the widest registers.
struct alignas(lanes * sizeof(double)) Number {
  Lanes value;
};

/// A complex number a lane.
struct alignas(lanes * sizeof(double)) ComplexNumber {
  Lanes re, im;
};

/// In place, as vectors passed by value would tie the call to one instruction set.
[[gnu::always_inline]] inline void take_root(Lanes& x) noexcept {
  for (Eigen::Index l = 0; l < lanes; ++l) x[l] = std::sqrt(x[l]);
}

}  // namespace stillframe

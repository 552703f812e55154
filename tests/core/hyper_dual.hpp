#pragma once

#include <cmath>

namespace stillframe::test {

/// a + b eps_1 + c eps_2 + d eps_1 eps_2 with eps_1^2 = eps_2^2 = 0: after a calculation with seeds
/// b and c, d is the second derivative in those two directions, exact but for rounding.
struct HyperDual {
  double value = 0, d1 = 0, d2 = 0, d12 = 0;
  HyperDual() = default;
  HyperDual(double v) : value(v) {}
  HyperDual(double v, double first, double second) : value(v), d1(first), d2(second) {}
};

inline HyperDual make(double v, double d1, double d2, double d12) {
  HyperDual result(v, d1, d2);
  result.d12 = d12;
  return result;
}
inline HyperDual operator+(const HyperDual& a, const HyperDual& b) {
  return make(a.value + b.value, a.d1 + b.d1, a.d2 + b.d2, a.d12 + b.d12);
}
inline HyperDual operator-(const HyperDual& a, const HyperDual& b) {
  return make(a.value - b.value, a.d1 - b.d1, a.d2 - b.d2, a.d12 - b.d12);
}
inline HyperDual operator*(const HyperDual& a, const HyperDual& b) {
  return make(a.value * b.value, a.d1 * b.value + a.value * b.d1, a.d2 * b.value + a.value * b.d2,
              a.d12 * b.value + a.d1 * b.d2 + a.d2 * b.d1 + a.value * b.d12);
}
inline HyperDual square_root(const HyperDual& a) {
  const double root = std::sqrt(a.value), first = 0.5 / root, second = -0.25 / (root * a.value);
  return make(root, first * a.d1, first * a.d2, first * a.d12 + second * a.d1 * a.d2);
}
inline double square_root(double a) { return std::sqrt(a); }

/// 113 bits: what is exact enough to judge the last digits of a double.
__extension__ using Quad = __float128;
inline Quad square_root(Quad a) {
  if (a == 0) return 0;
  Quad root = std::sqrt(static_cast<double>(a));
  // Newton's method doubles the 53 good bits with each step.
  for (int i = 0; i < 3; ++i) root = (root + a / root) / 2;
  return root;
}

}  // namespace stillframe::test

#pragma once

#include <cmath>

namespace stillframe::test {

/// a + b eps with eps^2 = 0: a calculation on it gives the derivative exact but for rounding. Over
/// itself it gives the mixed higher derivatives, one eps a level.
template <class T>
struct Dual {
  T value, d;
  Dual(double v = 0) : value(v), d(0.0) {}
  Dual(const T& v, const T& derivative) : value(v), d(derivative) {}
};

/// a + b eps_1 + c eps_2 + d eps_1 eps_2.
using HyperDual = Dual<Dual<double>>;
inline HyperDual hyper_dual(double v, double d1, double d2, double d12 = 0) {
  return {Dual<double>(v, d1), Dual<double>(d2, d12)};
}
inline double first(const HyperDual& a) { return a.value.d; }
inline double second(const HyperDual& a) { return a.d.d; }

template <class T>
Dual<T> operator+(const Dual<T>& a, const Dual<T>& b) {
  return {a.value + b.value, a.d + b.d};
}
template <class T>
Dual<T> operator-(const Dual<T>& a, const Dual<T>& b) {
  return {a.value - b.value, a.d - b.d};
}
template <class T>
Dual<T> operator*(const Dual<T>& a, const Dual<T>& b) {
  return {a.value * b.value, a.d * b.value + a.value * b.d};
}
template <class T>
Dual<T> operator/(const Dual<T>& a, const Dual<T>& b) {
  const T ratio = a.value / b.value;
  return {ratio, (a.d - ratio * b.d) / b.value};
}

inline double square_root(double a) { return std::sqrt(a); }
inline double sine(double a) { return std::sin(a); }
inline double cosine(double a) { return std::cos(a); }
inline double arc_tangent(double y, double x) { return std::atan2(y, x); }

template <class T>
Dual<T> square_root(const Dual<T>& a) {
  const T root = square_root(a.value);
  return {root, a.d / (root + root)};
}
template <class T>
Dual<T> sine(const Dual<T>& a) {
  return {sine(a.value), cosine(a.value) * a.d};
}
template <class T>
Dual<T> cosine(const Dual<T>& a) {
  return {cosine(a.value), T(0.0) - sine(a.value) * a.d};
}
/// The angle of (x, y), in (-pi, pi].
template <class T>
Dual<T> arc_tangent(const Dual<T>& y, const Dual<T>& x) {
  return {arc_tangent(y.value, x.value),
          (x.value * y.d - y.value * x.d) / (x.value * x.value + y.value * y.value)};
}

/// 113 bits: what is exact enough to judge the last digits of a double.
__extension__ using Quad = __float128;
inline Quad square_root(Quad a) {
  if (a == 0) return 0;
  Quad root = std::sqrt(static_cast<double>(a));
  // Newton's method doubles the 53 good bits with each step.
  for (int i = 0; i < 3; ++i) root = (root + a / root) / 2;
  return root;
}
/// The sum of (-1)^k a^(2k + n) / (2k + n)!, for angles of a few radians.
inline Quad alternating_series(Quad a, int n) {
  Quad term = n == 0 ? Quad(1) : a, sum = term;
  for (int k = n + 1; k < 80; k += 2) {
    term *= -a * a / (Quad(k) * (k + 1));
    sum += term;
  }
  return sum;
}
inline Quad sine(Quad a) { return alternating_series(a, 1); }
inline Quad cosine(Quad a) { return alternating_series(a, 0); }
inline Quad arc_tangent(Quad y, Quad x) {
  const Quad start = std::atan2(static_cast<double>(y), static_cast<double>(x));
  // What is left is an angle of 1e-16, whose sine it is to 1e-48.
  return start + (y * cosine(start) - x * sine(start)) / square_root(x * x + y * y);
}

}  // namespace stillframe::test

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace stillframe {

/// A number as the unevaluated sum of two doubles, high the one nearest to it: 106 bits, relative
/// rounding below 2^-102 in every operation, the range of a double. Made from doubles it is exact.
/// Sources: Joldes, Muller and Popescu, ACM Transactions on Mathematical Software 44 (2017) 15,
/// algorithms 6 and 11; the square root after Lefevre, Louvet, Muller, Picot and Rideau, the
/// same 49 (2023) 12.
struct DoubleDouble {
  double high = 0, low = 0;

  DoubleDouble() = default;
  // Implicit, so that formulas may hold plain numbers.
  DoubleDouble(double value) : high(value) {}
  DoubleDouble(double large, double small) : high(large), low(small) {}
  explicit operator double() const { return high; }

  /// a + b, exactly; |a| >= |b|.
  static DoubleDouble fast_sum(double a, double b) {
    const double sum = a + b;
    return {sum, b - (sum - a)};
  }
  /// a + b, exactly.
  static DoubleDouble sum(double a, double b) {
    const double sum = a + b, part = sum - a;
    return {sum, (a - (sum - part)) + (b - part)};
  }
  /// a b, exactly.
  static DoubleDouble product(double a, double b) {
    const double product = a * b;
    return {product, std::fma(a, b, -product)};
  }

  friend DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
  friend DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = sum(a.high, b.high), t = sum(a.low, b.low);
    const DoubleDouble v = fast_sum(s.high, s.low + t.high);
    return fast_sum(v.high, t.low + v.low);
  }
  friend DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }
  friend DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble p = product(a.high, b.high);
    return fast_sum(p.high, p.low + std::fma(a.low, b.high, a.high * b.low));
  }
  friend DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
    const double quotient = a.high / b.high;
    const DoubleDouble rest = a - b * DoubleDouble(quotient);
    return fast_sum(quotient, rest.high / b.high);
  }
  DoubleDouble& operator+=(DoubleDouble b) { return *this = *this + b; }
  DoubleDouble& operator-=(DoubleDouble b) { return *this = *this - b; }
  DoubleDouble& operator*=(DoubleDouble b) { return *this = *this * b; }
  DoubleDouble& operator/=(DoubleDouble b) { return *this = *this / b; }

  friend bool operator==(DoubleDouble a, DoubleDouble b) {
    return a.high == b.high && a.low == b.low;
  }
  friend bool operator<(DoubleDouble a, DoubleDouble b) {
    return a.high < b.high || (a.high == b.high && a.low < b.low);
  }
  friend bool operator>(DoubleDouble a, DoubleDouble b) { return b < a; }
  friend bool operator<=(DoubleDouble a, DoubleDouble b) { return a < b || a == b; }
  friend bool operator>=(DoubleDouble a, DoubleDouble b) { return b <= a; }

  friend DoubleDouble abs(DoubleDouble a) { return a.high < 0 ? -a : a; }
  friend DoubleDouble sqrt(DoubleDouble a) {
    if (a.high == 0) return a;
    const double root = std::sqrt(a.high);
    return fast_sum(root, (std::fma(-root, root, a.high) + a.low) / (2 * root));
  }
  friend bool isfinite(DoubleDouble a) { return std::isfinite(a.high); }
  friend bool isinf(DoubleDouble a) { return std::isinf(a.high); }
  friend bool isnan(DoubleDouble a) { return std::isnan(a.high); }
};

using ExtendedMatrix = Eigen::Matrix<DoubleDouble, Eigen::Dynamic, Eigen::Dynamic>;
using ExtendedVector = Eigen::Matrix<DoubleDouble, Eigen::Dynamic, 1>;

}  // namespace stillframe

/// What Eigen's decompositions ask of a number.
template <>
struct std::numeric_limits<stillframe::DoubleDouble> : std::numeric_limits<double> {
  static constexpr int digits = 102;
  static stillframe::DoubleDouble epsilon() { return 0x1p-102; }
  static stillframe::DoubleDouble min() { return std::numeric_limits<double>::min(); }
  static stillframe::DoubleDouble max() { return std::numeric_limits<double>::max(); }
  static stillframe::DoubleDouble lowest() { return std::numeric_limits<double>::lowest(); }
};

template <>
struct Eigen::NumTraits<stillframe::DoubleDouble>
    : Eigen::GenericNumTraits<stillframe::DoubleDouble> {
  enum { RequireInitialization = 1, ReadCost = 2, AddCost = 20, MulCost = 10 };
  static stillframe::DoubleDouble dummy_precision() { return 0x1p-90; }
  static int digits10() { return 30; }
};

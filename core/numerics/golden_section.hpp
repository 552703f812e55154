#pragma once

#include <utility>

namespace stillframe {

/// Where a function has its highest point, and how high that is.
struct Highest {
  double at = 0, value = 0;
};

/// The highest point of f between low and high, where it has one there, by golden sections: as many
/// as are given, and no more once the bracket is no wider than `part` of its upper end.
template <class F>
Highest golden_section(F&& f, double low, double high, int sections, double part = 0) {
  constexpr double golden = 0.6180339887498949;
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double f_a = f(a), f_b = f(b);
  for (int i = 0; i < sections && high - low > part * high; ++i) {
    if (f_a > f_b) {
      high = b;
      b = a;
      f_b = f_a;
      a = high - golden * (high - low);
      f_a = f(a);
    } else {
      low = a;
      a = b;
      f_a = f_b;
      b = low + golden * (high - low);
      f_b = f(b);
    }
  }
  return f_a > f_b ? Highest{a, f_a} : Highest{b, f_b};
}

}  // namespace stillframe

#pragma once

#include <cmath>

namespace stillframe {

/// A sum of products as if computed in twice the working precision and then rounded. Hot: noexcept,
/// no allocation. Source: Ogita, Rump and Oishi, SIAM Journal on Scientific Computing 26 (2005)
/// 1955-1988, algorithm 5.3 (Dot2).
class DoubledSum {
 public:
  explicit DoubledSum(double start) noexcept : sum_(start) {}

  void add(double a, double b) noexcept {
    const double product = a * b, product_error = std::fma(a, b, -product);
    const double sum = sum_ + product, part = sum - sum_;
    const double sum_error = (sum_ - (sum - part)) + (product - part);
    sum_ = sum;
    error_ += product_error + sum_error;
  }

  double value() const noexcept { return sum_ + error_; }

 private:
  double sum_, error_ = 0.0;
};

}  // namespace stillframe

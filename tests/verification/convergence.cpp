#include "tests/verification/convergence.hpp"

#include <cmath>
#include <iostream>

namespace stillframe::verification {

int elements_needed(const Error& error, double tolerance, int first, int last) {
  int good = 0;
  for (int n = first; n <= last; ++n) {
    good = std::abs(error(n)) <= tolerance ? good + 1 : 0;
    if (good == 3) return n - 2;
  }
  return -1;
}

double observed_order(const Error& error, int n) {
  return std::log2(std::abs(error(n) / error(2 * n)));
}

int extrapolated_count(const Error& error, int n, double order, double tolerance) {
  return static_cast<int>(std::ceil(n * std::pow(std::abs(error(n)) / tolerance, 1 / order)));
}

void print_counts(const std::string& name, const Error& error, int first, int last) {
  const int coarse = elements_needed(error, 1e-3, first, last);
  const int fine = elements_needed(error, 1e-5, coarse > 0 ? coarse : first, last);
  const auto text = [&](int n) {
    return n > 0 ? std::to_string(n) : "more than " + std::to_string(last);
  };
  std::cout << name << ": 1e-3 with " << text(coarse) << " elements, 1e-5 with " << text(fine)
            << "\n";
}

}  // namespace stillframe::verification

#pragma once

#include <functional>
#include <string>

namespace stillframe::verification {

/// Relative error, or any other one, of a model of n elements.
using Error = std::function<double(int n)>;

/// The fewest elements, from `first` on, from which the error stays within a tolerance for three
/// numbers of elements in a row; -1 if that is not so up to `last`.
int elements_needed(const Error& error, double tolerance, int first = 1, int last = 100);

/// Order of convergence between n and 2 n elements.
double observed_order(const Error& error, int n);

/// The number of elements for a tolerance by extrapolation of the error of n elements at an order.
int extrapolated_count(const Error& error, int n, double order, double tolerance);

/// Prints "NAME: 1e-3 with A elements, 1e-5 with B".
void print_counts(const std::string& name, const Error& error, int first = 1, int last = 100);

}  // namespace stillframe::verification

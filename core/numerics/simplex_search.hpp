#pragma once

#include <Eigen/Core>
#include <functional>

namespace stillframe {

/// Where a function is least near a start, and how low that is.
struct Lowest {
  Eigen::VectorXd at;
  double value = 0;
};

/// The lowest point that the simplex of Nelder and Mead finds from `start` (n numbers) with edges
/// of `step`, after so many values of f or where its values and its corners are within `close` of
/// each other. f need not be smooth; where it is infinite the simplex turns back. Source: Nelder
/// and Mead, The Computer Journal 7 (1965) 308-313. Set-up.
Lowest simplex_search(const std::function<double(const Eigen::VectorXd&)>& f,
                      const Eigen::VectorXd& start, double step, int values, double close);

}  // namespace stillframe

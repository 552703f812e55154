#include "tools/largest_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/errors/formatted.hpp"

namespace stillframe::tools {

std::string largest_parts(const std::vector<std::string>& names, const Eigen::VectorXd& shape,
                          std::size_t count) {
  std::vector<Eigen::Index> order(names.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::abs(shape(a)) > std::abs(shape(b));
  });
  std::string text;
  for (std::size_t k = 0; k < std::min(order.size(), count); ++k) {
    const double part = shape(order[k]) / shape(order[0]);
    // What is a thousandth of the largest is not seen in the shape; nor is 0 / 0.
    if (!(std::abs(part) >= 1e-3)) break;
    text += (text.empty() ? "" : ", ") + names[static_cast<std::size_t>(order[k])] +
            formatted(" %.3g", part);
  }
  return text;
}

}  // namespace stillframe::tools

#include "core/numerics/simplex_search.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stillframe {

using Eigen::VectorXd;

Lowest simplex_search(const std::function<double(const VectorXd&)>& f, const VectorXd& start,
                      double step, int values, double close) {
  std::vector<Lowest> corners{{start, f(start)}};
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    VectorXd corner = start;
    corner(i) += step;
    corners.push_back({corner, f(corner)});
  }
  const auto lower = [](const Lowest& a, const Lowest& b) { return a.value < b.value; };
  int left = values - static_cast<int>(corners.size());
  while (left > 0) {
    std::sort(corners.begin(), corners.end(), lower);
    const Lowest &best = corners.front(), &worst = corners.back();
    if (worst.value - best.value < close && (worst.at - best.at).norm() < close) break;
    VectorXd middle = VectorXd::Zero(start.size());
    for (size_t i = 0; i + 1 < corners.size(); ++i) middle += corners[i].at;
    middle /= static_cast<double>(start.size());
    const auto along = [&](double t) {
      const VectorXd at = middle + t * (corners.back().at - middle);
      --left;
      return Lowest{at, f(at)};
    };
    Lowest next = along(-1);
    if (next.value < best.value) {
      const Lowest further = along(-2);
      if (further.value < next.value) next = further;
    } else if (!(next.value < corners[corners.size() - 2].value)) {
      const Lowest nearer = along(next.value < worst.value ? -0.5 : 0.5);
      if (!(nearer.value < std::min(next.value, worst.value))) {
        for (size_t i = 1; i < corners.size(); ++i) {
          corners[i].at = (corners[i].at + corners.front().at) / 2;
          corners[i].value = f(corners[i].at);
          --left;
        }
        continue;
      }
      next = nearer;
    }
    corners.back() = next;
  }
  return *std::min_element(corners.begin(), corners.end(), lower);
}

}  // namespace stillframe

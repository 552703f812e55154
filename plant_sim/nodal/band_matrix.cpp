#include "plant_sim/nodal/band_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace stillframe::nodal {

namespace {

using Neighbours = std::vector<std::vector<Index>>;

Neighbours neighbours_of(Index n, const Groups& groups) {
  std::vector<std::set<Index>> sets(static_cast<size_t>(n));
  for (const auto& group : groups) {
    for (const Index i : group) sets[static_cast<size_t>(i)].insert(group.begin(), group.end());
  }
  Neighbours neighbours;
  for (const auto& set : sets) neighbours.emplace_back(set.begin(), set.end());
  return neighbours;
}

/// All that hang together with `start`, by their distance, those with few neighbours first.
std::vector<Index> levels_from(Index start, const Neighbours& neighbours) {
  const auto degree = [&](Index i) { return neighbours[static_cast<size_t>(i)].size(); };
  std::vector<Index> order{start};
  std::vector<bool> reached(neighbours.size(), false);
  reached[static_cast<size_t>(start)] = true;
  for (size_t at = 0; at < order.size(); ++at) {
    const auto first = static_cast<std::ptrdiff_t>(order.size());
    for (const Index j : neighbours[static_cast<size_t>(order[at])]) {
      if (reached[static_cast<size_t>(j)]) continue;
      reached[static_cast<size_t>(j)] = true;
      order.push_back(j);
    }
    std::stable_sort(order.begin() + first, order.end(),
                     [&](Index i, Index j) { return degree(i) < degree(j); });
  }
  return order;
}

}  // namespace

std::vector<Index> narrow_ordering(Index n, const Groups& groups) {
  const Neighbours neighbours = neighbours_of(n, groups);
  std::vector<Index> order;
  std::vector<bool> done(static_cast<size_t>(n), false);
  for (Index i = 0; i < n; ++i) {
    if (done[static_cast<size_t>(i)]) continue;
    // The last one reached from anywhere is at the rim; from there, once more.
    Index rim = levels_from(i, neighbours).back();
    rim = levels_from(rim, neighbours).back();
    for (const Index j : levels_from(rim, neighbours)) {
      done[static_cast<size_t>(j)] = true;
      order.push_back(j);
    }
  }
  std::vector<Index> place(static_cast<size_t>(n));
  for (Index k = 0; k < n; ++k) {
    place[static_cast<size_t>(order[static_cast<size_t>(k)])] = n - 1 - k;
  }
  return place;
}

Index half_bandwidth(const std::vector<Index>& place, const Groups& groups) {
  Index b = 0;
  for (const auto& group : groups) {
    for (const Index i : group) {
      for (const Index j : group) {
        b = std::max(b, place[static_cast<size_t>(i)] - place[static_cast<size_t>(j)]);
      }
    }
  }
  return b;
}

BandMatrix::BandMatrix(Index n, Index b) : b_(b), values_(Eigen::MatrixXd::Zero(2 * b + 1, n)) {}

void BandMatrix::add_product(const Eigen::VectorXd& x, Eigen::VectorXd& y) const noexcept {
  const Index n = size();
  for (Index j = 0; j < n; ++j) {
    if (x(j) == 0) continue;
    const Index first = std::max<Index>(0, j - b_), last = std::min(n - 1, j + b_);
    y.segment(first, last - first + 1) +=
        x(j) * values_.col(j).segment(b_ + first - j, last - first + 1);
  }
}

template <class Scalar>
BandFactors<Scalar>::BandFactors(Index n, Index b)
    : b_(b), values_(decltype(values_)::Zero(3 * b + 1, n)), pivots_(static_cast<size_t>(n)) {}

template <class Scalar>
bool BandFactors<Scalar>::factorise(const BandMatrix& A_0, Scalar c, const BandMatrix& A_1,
                                    const BandMatrix& A_2) noexcept {
  values_.topRows(b_).setZero();
  const Scalar c_2 = c * c;
  values_.bottomRows(2 * b_ + 1) = A_0.values().template cast<Scalar>() +
                                   c * A_1.values().template cast<Scalar>() +
                                   c_2 * A_2.values().template cast<Scalar>();
  return eliminate();
}

template <class Scalar>
bool BandFactors<Scalar>::factorise(const BandMatrix& A) noexcept {
  values_.topRows(b_).setZero();
  values_.bottomRows(2 * b_ + 1) = A.values().template cast<Scalar>();
  return eliminate();
}

template <class Scalar>
void BandFactors<Scalar>::exchange(Index k, Index pivot) noexcept {
  const Index last = std::min(values_.cols() - 1, k + 2 * b_);
  for (Index j = k; j <= last; ++j) {
    std::swap(values_(2 * b_ + k - j, j), values_(2 * b_ + pivot - j, j));
  }
}

template <class Scalar>
bool BandFactors<Scalar>::eliminate() noexcept {
  const Index n = values_.cols();
  for (Index k = 0; k < n; ++k) {
    const Index below = std::min(b_, n - 1 - k);
    Index pivot = 0;
    const double largest = values_.col(k).segment(2 * b_, below + 1).cwiseAbs().maxCoeff(&pivot);
    if (!(largest > 0) || !std::isfinite(largest)) return false;
    pivots_[static_cast<size_t>(k)] = k + pivot;
    if (pivot != 0) exchange(k, k + pivot);
    auto factors = values_.col(k).segment(2 * b_ + 1, below);
    factors /= values_(2 * b_, k);
    const Index last = std::min(n - 1, k + 2 * b_);
    for (Index j = k + 1; j <= last; ++j) {
      const Scalar entry = values_(2 * b_ + k - j, j);
      if (entry != Scalar(0)) values_.col(j).segment(2 * b_ + k + 1 - j, below) -= entry * factors;
    }
  }
  return true;
}

template <class Scalar>
void BandFactors<Scalar>::solve(Vector& x) const noexcept {
  const Index n = values_.cols();
  for (Index k = 0; k < n; ++k) {
    std::swap(x(k), x(pivots_[static_cast<size_t>(k)]));
    const Index below = std::min(b_, n - 1 - k);
    x.segment(k + 1, below) -= x(k) * values_.col(k).segment(2 * b_ + 1, below);
  }
  for (Index k = n - 1; k >= 0; --k) {
    x(k) /= values_(2 * b_, k);
    const Index above = std::min(2 * b_, k);
    x.segment(k - above, above) -= x(k) * values_.col(k).segment(2 * b_ - above, above);
  }
}

template class BandFactors<double>;
template class BandFactors<std::complex<double>>;

}  // namespace stillframe::nodal

#include "core/control/feed_forward.hpp"

#include <stdexcept>

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Complex = std::complex<double>;

namespace {

/// One channel: states (w, s, h, ..., l_1, l_2) of the sample before, with s the first washout and
/// n - 1 values of h; outputs the n + 2 terms.
struct Channel {
  MatrixXd A, C;
  Eigen::VectorXd B, D;
};

Channel channel_of(double a, Index n) {
  const Index total = n + 3, l_1 = n + 1, l_2 = n + 2;
  constexpr Index w = 0, s = 1, h = 2;
  // The present values as rows over (states, w).
  Eigen::RowVectorXd s_now = Eigen::RowVectorXd::Zero(total + 1), h_now = s_now, l_1_now = s_now;
  s_now(s) = a;
  s_now(w) = -1;
  s_now(total) = 1;
  h_now = s_now;
  h_now(s) -= 1;
  h_now(h) += a;
  l_1_now = (1 - a) * h_now;
  l_1_now(l_1) += a;
  Eigen::RowVectorXd l_2_now = (1 - a) * l_1_now;
  l_2_now(l_2) += a;

  MatrixXd next = MatrixXd::Zero(total, total + 1), terms = MatrixXd::Zero(n + 2, total + 1);
  next(w, total) = 1;
  next.row(s) = s_now;
  next.row(h) = terms.row(0) = h_now;
  for (Index i = 1; i < n; ++i) {
    terms(i, h + i - 1) = 1;
    if (i + 1 < n) next(h + i, h + i - 1) = 1;
  }
  next.row(l_1) = terms.row(n) = l_1_now;
  next.row(l_2) = terms.row(n + 1) = l_2_now;
  return {next.leftCols(total), terms.leftCols(total), next.col(total), terms.col(total)};
}

/// Every entry as so many channels side by side.
MatrixXd for_channels(const MatrixXd& one, Index p) {
  MatrixXd all = MatrixXd::Zero(one.rows() * p, one.cols() * p);
  for (Index i = 0; i < one.rows(); ++i) {
    for (Index j = 0; j < one.cols(); ++j) {
      all.block(i * p, j * p, p, p).diagonal().setConstant(one(i, j));
    }
  }
  return all;
}

}  // namespace

Eigen::VectorXcd feed_forward_terms(double memory, Index n_taps, Complex z) {
  const Complex washout = (1.0 - 1.0 / z) / (1.0 - memory / z), h = washout * washout;
  const Complex low_pass = (1 - memory) / (1.0 - memory / z);
  Eigen::VectorXcd terms(n_taps + 2);
  Complex late = h;
  for (Index i = 0; i < n_taps; ++i, late /= z) terms(i) = late;
  terms(n_taps) = low_pass * h;
  terms(n_taps + 1) = low_pass * low_pass * h;
  return terms;
}

Eigen::MatrixXcd response_of(const FeedForward& filter, Complex z) {
  const Eigen::VectorXcd terms = feed_forward_terms(filter.memory, filter.n_taps, z);
  const Index p = filter.n_floor();
  Eigen::MatrixXcd sum = Eigen::MatrixXcd::Zero(filter.weights.rows(), p);
  for (Index i = 0; i < terms.size(); ++i) sum += terms(i) * filter.weights.middleCols(i * p, p);
  return sum;
}

LinearSystem feed_forward_system(const FeedForward& filter) {
  if (filter.empty()) return {};
  const Index p = filter.n_floor();
  if (filter.n_taps < 2 || p == 0 || filter.weights.cols() != p * filter.n_terms() ||
      !(filter.memory >= 0 && filter.memory < 1)) {
    throw std::invalid_argument(
        "feed_forward_system: two taps or more, a memory below one, and weights of taps and two "
        "integrals for each channel are needed");
  }
  const Channel one = channel_of(filter.memory, filter.n_taps);
  return {.A = for_channels(one.A, p),
          .B = for_channels(one.B, p),
          .C = filter.weights * for_channels(one.C, p),
          .D = filter.weights * for_channels(one.D, p)};
}

}  // namespace stillframe

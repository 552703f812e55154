#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "controller/rig/probe.hpp"

namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index n_rows = 30, margin = 3, n_window = 4, most = 4;
constexpr double missing_part = 0.25;  // of a window of four, one sample

/// One leg, each signal on a line of its own; rows that are not there hold what nobody read.
Recording recorded(const std::vector<bool>& there) {
  Recording out;
  out.command = out.sigma = out.applied = out.frame = out.floor =
      Eigen::MatrixXd::Constant(n_rows, 1, std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < n_rows; ++k) {
    if (!there[static_cast<std::size_t>(k)]) continue;
    const auto at = static_cast<double>(k);
    out.sigma(k, 0) = at;
    out.applied(k, 0) = 2 * at;
    out.frame(k, 0) = 3 * at;
    out.floor(k, 0) = -at;
  }
  return out;
}

Recording chosen(const std::vector<bool>& there) {
  Recording out = recorded(there);
  choose_windows(out, there, margin, n_window, most, 1, 1, missing_part);
  return out;
}

/// Two at rest, one in which the drive rises, one driven, one in which it falls, are seven windows
/// at most; what lies before the first sample and behind the last is no number of anybody's.
TEST(Recording, RowsWithoutASampleAreHeldAtBothEndsAndOnLinesBetween) {
  std::vector<bool> there(n_rows, true);
  for (const std::size_t k : {0, 1, 9, 27, 28, 29}) there[k] = false;
  const Recording out = chosen(there);
  const double inside[] = {2, 2, 2};
  for (Index k = 0; k < n_rows; ++k) {
    const double expected = k < 2 ? inside[k] : k > 26 ? 26 : static_cast<double>(k);
    EXPECT_DOUBLE_EQ(out.sigma(k, 0), expected) << k;
    EXPECT_DOUBLE_EQ(out.applied(k, 0), 2 * expected) << k;
    EXPECT_DOUBLE_EQ(out.frame(k, 0), 3 * expected) << k;
    EXPECT_DOUBLE_EQ(out.floor(k, 0), -expected) << k;
  }
  EXPECT_EQ(out.n_samples, n_rows - 6);
  EXPECT_EQ(out.n_lost, 6);
  for (std::size_t k = 0; k < there.size(); ++k) EXPECT_NE(out.missing[k], there[k]) << k;
}

/// A single sample is all there is to hold, and of none nothing can be said.
TEST(Recording, OneSampleIsHeldThroughout) {
  std::vector<bool> there(n_rows, false);
  there[7] = true;
  Recording out = recorded(there);
  choose_windows(out, there, margin, n_window, 0, 0, 0, missing_part);
  for (Index k = 0; k < n_rows; ++k) EXPECT_EQ(out.frame(k, 0), 21) << k;
  EXPECT_THROW(chosen(std::vector<bool>(n_rows, false)), std::runtime_error);
}

}  // namespace
}  // namespace stillframe::controller

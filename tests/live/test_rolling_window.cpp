#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "report/live/rolling_window.hpp"

namespace stillframe::live {
namespace {

TEST(RollingWindow, HoldsTheNewestInTheirOrderWhereverTheRingBegins) {
  RollingWindow window(2, 5);
  for (int k = 0; k < 23; ++k) {
    window.push(std::vector<double>{1. * k, -10. * k});
    const Eigen::Index size = std::min(k + 1, 5);
    ASSERT_EQ(window.size(), size);
    for (Eigen::Index n = 0; n <= size; ++n) {
      const Eigen::VectorXd first = window.newest(0, n), second = window.newest(1, n);
      for (Eigen::Index i = 0; i < n; ++i) {
        EXPECT_EQ(first(i), k - n + 1 + i);
        EXPECT_EQ(second(i), -10 * (k - n + 1 + i));
      }
    }
    EXPECT_EQ(window.last(0), k);
    EXPECT_EQ(window.last(1), -10 * k);
  }
  window.clear();
  EXPECT_EQ(window.size(), 0);
  EXPECT_EQ(window.newest(0, 0).size(), 0);
}

TEST(RollingWindow, RefusesWhatItCannotBe) {
  EXPECT_THROW(RollingWindow(1, 0), std::invalid_argument);
  EXPECT_THROW(RollingWindow(-1, 4), std::invalid_argument);
  RollingWindow window(1, 4);
  window.push(std::vector<double>{1});
  EXPECT_THROW(window.newest(0, 2), std::invalid_argument);
  EXPECT_THROW(window.newest(1, 1), std::invalid_argument);
  EXPECT_THROW(window.newest(-1, 1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::live

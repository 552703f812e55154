#include <gtest/gtest.h>

#include <cmath>

#include "tests/faults/table.hpp"

namespace stillframe::faults {
namespace {

KindResult row(double ratio) {
  KindResult result;
  result.allowed = {"active"};
  result.exit_code = 4;
  for (const double over : {0.5, ratio, 0.6}) {
    Episode episode;
    episode.outcome = "active";
    episode.over_passive = over;
    result.episodes.push_back(episode);
  }
  return result;
}

// Whatever comes behind it: the largest of what is no number is none.
TEST(Table, ARatioThatIsNoNumberIsShownAndFails) {
  EXPECT_EQ(failures(row(0.7)), std::vector<std::string>{});
  EXPECT_NE(markdown({row(0.7)}).find("| 0.70 | 0.00 |"), std::string::npos);
  EXPECT_EQ(failures(row(NAN)).size(), 1u);
  EXPECT_NE(markdown({row(NAN)}).find("| nan | 0.00 |"), std::string::npos) << markdown({row(NAN)});
}

}  // namespace
}  // namespace stillframe::faults

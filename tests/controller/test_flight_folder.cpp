#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>
#include <set>
#include <string>

#include "controller/flight_folder.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::controller {
namespace {

namespace fs = std::filesystem;

class FlightFolder : public testing::Test {
 protected:
  /// A file of so many bytes, written so many seconds after the first.
  void write(const std::string& name, std::size_t bytes, int at_s) {
    std::ofstream(folder_ / name) << std::string(bytes, 'x');
    fs::last_write_time(folder_ / name, fs::file_time_type{} + std::chrono::seconds(at_s));
  }
  std::set<std::string> names() const {
    std::set<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      all.insert(entry.path().filename().string());
    }
    return all;
  }

  const test::ScratchFolder scratch_;
  const fs::path& folder_ = scratch_.path();
};

TEST_F(FlightFolder, NamesGoUpAndAreNotUsedAgain) {
  EXPECT_EQ(next_flight_file(folder_, 7), folder_ / "flight-7-1.lcm");
  write("flight-7-9.lcm", 1, 0);
  write("flight-7-10.lcm", 1, 1);
  write("flight-77-30.lcm", 1, 1);
  write("flight--7-40.lcm", 1, 1);
  EXPECT_EQ(next_flight_file(folder_, 7), folder_ / "flight-7-11.lcm");
  EXPECT_EQ(next_flight_file(folder_, -7), folder_ / "flight--7-41.lcm");
}

// Whatever is there, the newest stay, as many of them as the bounds allow, and nothing else goes.
TEST_F(FlightFolder, TheOldestGoUntilTheRestIsWithinTheBounds) {
  const std::set<std::string> others{"flight-1.lcm", "flight-1-2.lcm.bak", "my-flight-1-2.lcm",
                                     "run.lcm",      "flight-a-1.lcm",     "notes.txt"};
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    const int n = static_cast<int>(random() % 12);
    const FlightBounds bounds{.files = static_cast<std::int64_t>(1 + random() % 12),
                              .bytes = static_cast<double>(1 + random() % 500)};
    for (const std::string& name : others) write(name, 1000, -1);
    std::vector<std::size_t> sizes;
    for (int i = 0; i < n; ++i) {
      sizes.push_back(random() % 100);
      write("flight-3-" + std::to_string(i + 1) + ".lcm", sizes.back(), i);
    }
    make_room(folder_, bounds);
    std::set<std::string> expected = others;
    double bytes = 0;
    for (int i = n - 1, files = 1; i >= 0; --i, ++files) {
      bytes += static_cast<double>(sizes[static_cast<std::size_t>(i)]);
      if (i < n - 1 && (files > bounds.files || bytes > bounds.bytes)) break;
      expected.insert("flight-3-" + std::to_string(i + 1) + ".lcm");
    }
    EXPECT_EQ(names(), expected) << "seed " << seed;
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
}

TEST_F(FlightFolder, WhatAKilledControllerLeftUnfinishedGoes) {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);  // so nobody has its number any more
  const std::string gone = "flight-3-1.lcm.incomplete-" + std::to_string(child) + "-1";
  const std::string ours = "flight-3-2.lcm.incomplete-" + std::to_string(getpid()) + "-1";
  write(gone, 10, 0);
  write(ours, 10, 0);
  make_room(folder_, {.files = 100, .bytes = 1e9});
  EXPECT_EQ(names(), std::set{ours});
}

}  // namespace
}  // namespace stillframe::controller

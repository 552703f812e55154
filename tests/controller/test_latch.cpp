#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "controller/latch.hpp"
#include "core/errors/input_error.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::controller {
namespace {

namespace fs = std::filesystem;

class LatchTest : public testing::Test {
 protected:
  Latch latch(bool clear_at_once = false) {
    return {file_, disk_, [this](const std::string& text) { warned_ += text; }, clear_at_once};
  }
  void written() { ASSERT_TRUE(disk_.finish(600)); }

  const test::ScratchFolder scratch_;
  const fs::path& folder_ = scratch_.path();
  fs::path file_ = folder_ / "not/there/yet/latch.yaml";
  std::string warned_;
  Background disk_{16};
};

TEST_F(LatchTest, EveryFaultOutlivesTheProcessUntilItIsCleared) {
  EXPECT_EQ(latch().fault(), Fault::none);
  int n = 0;
  for (std::int32_t i = 1; to_text(static_cast<Fault>(i)) != "unknown"; ++i, ++n) {
    const auto fault = static_cast<Fault>(i);
    latch().hold(fault, -7);
    written();
    Latch later = latch();
    EXPECT_EQ(later.fault(), fault);
    later.clear();
    EXPECT_EQ(later.fault(), Fault::none);
    written();
    EXPECT_EQ(latch().fault(), Fault::none);
    EXPECT_FALSE(fs::exists(file_));
  }
  EXPECT_GE(n, 9);
  EXPECT_EQ(warned_, "");
}

TEST_F(LatchTest, KeepsTheLegWhateverItIsCalled) {
  for (const char* name : {"leg_2", "no", "4", " a: \"b\"\\ \n#", ""}) {
    latch().hold(Fault::disobeyed, 3, name);
    written();
    Latch later = latch();
    EXPECT_EQ(later.fault(), Fault::disobeyed);
    EXPECT_EQ(later.leg(), name);
    later.clear();
    EXPECT_EQ(later.leg(), "");
    written();
  }
}

TEST_F(LatchTest, AFileThatNamesNoFaultIsRefusedAndCanBeCleared) {
  for (const char* text : {"fault: none\n", "fault: somewhat\n", "", "run_id: 1\n", "[",
                           "fault: limited\nmore: 1\n"}) {
    fs::create_directories(file_.parent_path());
    std::ofstream(file_) << text;
    EXPECT_THROW(latch(), InputError) << text;
    EXPECT_EQ(latch(true).fault(), Fault::none);
    written();
    EXPECT_EQ(latch().fault(), Fault::none);
  }
}

TEST_F(LatchTest, WhereItCannotBeWrittenItHoldsAndSaysSo) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "not") << "a file where a folder would be";
  Latch held = latch();
  held.hold(Fault::limited, 1);
  written();
  EXPECT_EQ(held.fault(), Fault::limited);
  EXPECT_NE(warned_.find("will not outlive this process"), std::string::npos) << warned_;
}

// Links that lead to each other, because a folder that may not be read is read by root.
TEST_F(LatchTest, WhereItCannotBeLookedForItIsNotTakenForNone) {
  fs::create_directories(folder_);
  fs::create_symlink(folder_ / "not", folder_ / "there");
  fs::create_symlink(folder_ / "there", folder_ / "not");
  try {
    latch();
    ADD_FAILURE() << "took it for none";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("not known whether a fault is latched"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(latch(true).fault(), Fault::none);
  written();
  EXPECT_NE(warned_.find("cannot be removed"), std::string::npos) << warned_;
}

TEST_F(LatchTest, IsKeptInTheUsersStateFolder) {
  const char* home = std::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  setenv("HOME", "/home/someone", 1);
  unsetenv("XDG_STATE_HOME");
  EXPECT_EQ(default_latch_file("0a1b"), "/home/someone/.local/state/stillframe/latch-0a1b.yaml");
  EXPECT_EQ(default_latch_file("../x"), "/home/someone/.local/state/stillframe/latch-___x.yaml");
  setenv("XDG_STATE_HOME", "/state", 1);
  EXPECT_EQ(default_latch_file("A frame"), "/state/stillframe/latch-A_frame.yaml");
  // A name has 255 bytes at most; up to 30 more are behind it while it is written (WholeFile).
  EXPECT_LE(default_latch_file(std::string(1000, 'x')).filename().string().size(), 255U - 30U);
  setenv("XDG_STATE_HOME", "state", 1);
  unsetenv("HOME");
  EXPECT_EQ(default_latch_file("0a1b"), "");
  unsetenv("XDG_STATE_HOME");
  if (home != nullptr) setenv("HOME", before.c_str(), 1);
}

}  // namespace
}  // namespace stillframe::controller

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

class WholeFiles : public testing::Test {
 protected:
  std::string text(const std::string& name) const {
    std::ifstream stream(folder_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  long files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  const ScratchFolder scratch_;
  const fs::path& folder_ = scratch_.path();
};

/// While it lives no file grows beyond so many bytes: what a full disk does, without one.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(WholeFiles, NothingIsThereBeforeItIsSaved) {
  write_whole_file(folder_ / "a", "older");
  {
    WholeFile file(folder_ / "a");
    file.write("newer");
    EXPECT_EQ(text("a"), "older");
    WholeFile second(folder_ / "a");  // of another thread or process: not the same temporary name
    EXPECT_NE(second.present(), file.present());
    EXPECT_EQ(files(), 3);
  }
  EXPECT_EQ(text("a"), "older");
  EXPECT_EQ(files(), 1);
  write_whole_file(folder_ / "a", "newer");
  EXPECT_EQ(text("a"), "newer");
  EXPECT_EQ(files(), 1);
}

TEST_F(WholeFiles, AFullDiskLeavesTheOlderFileAndNothingElse) {
  write_whole_file(folder_ / "a", "older");
  // Below and above what is kept in memory before it is written.
  for (const std::size_t size : {std::size_t{5000}, std::size_t{3} << 20}) {
    const SmallFiles limit(4096);
    EXPECT_THROW(write_whole_file(folder_ / "a", std::string(size, 'x')), OutputError) << size;
    EXPECT_THROW(WholeFile(folder_ / "a").leave(static_cast<std::int64_t>(size)), OutputError);
    EXPECT_EQ(text("a"), "older");
    EXPECT_EQ(files(), 1);
  }
  EXPECT_THROW(write_whole_file("/dev/full", "x"), OutputError);
}

TEST_F(WholeFiles, OfNoNameIsNone) { EXPECT_THROW(WholeFile(""), InputError); }

TEST_F(WholeFiles, WhatIsNoRegularFileIsWrittenToAndStays) {
  fs::create_symlink("b", folder_ / "link");
  fs::create_symlink("/dev/null", folder_ / "device");
  write_whole_file(folder_ / "b", "older");
  write_whole_file(folder_ / "link", "newer");
  write_whole_file(folder_ / "device", "nothing");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link") && fs::is_symlink(folder_ / "device"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_EQ(text("b"), "newer");
  fs::create_symlink("c", folder_ / "ahead");
  write_whole_file(folder_ / "ahead", "first");
  EXPECT_TRUE(fs::is_symlink(folder_ / "ahead"));
  EXPECT_EQ(text("c"), "first");
  EXPECT_THROW(WholeFile{folder_}, InputError);
  EXPECT_THROW(WholeFile(folder_ / "none/a"), InputError);
  EXPECT_EQ(files(), 5);
}

TEST_F(WholeFiles, BytesLeftFreeAreFilledInAnyOrder) {
  WholeFile file(folder_ / "a");
  file.write("<");
  const std::int64_t hole = file.leave(6);
  file.write(">");
  file.write_at(hole + 3, "def");
  file.write_at(hole, "ab");
  file.save();
  EXPECT_EQ(text("a"), std::string("<ab\0def>", 8));
  EXPECT_EQ(file.size(), 8);
}

}  // namespace
}  // namespace stillframe::test

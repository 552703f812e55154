#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/fuzz/seeds.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::fuzz {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

class Corpus : public testing::TestWithParam<Target> {};

/// Hand-made and found files, and the sound ones that are made anew.
std::vector<std::filesystem::path> files_of(const std::string& target,
                                            const test::ScratchFolder& seeds) {
  write_seeds(seeds.path());
  std::vector<std::filesystem::path> files;
  const auto kept = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "tests/fuzz/corpus";
  for (const auto& top : {kept, seeds.path()}) {
    if (!std::filesystem::exists(top / target)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(top / target)) {
      files.push_back(entry.path());
    }
  }
  return files;
}

// What scripts/fuzz began with and what it once found: none of it may come back.
TEST_P(Corpus, IsReadWithoutAFinding) {
  const test::ScratchFolder seeds;
  int n_files = 0;
  for (const auto& path : files_of(GetParam().name, seeds)) {
    SCOPED_TRACE(path.filename().string());
    const std::string bytes = bytes_of(path);
    EXPECT_FALSE(bytes.empty());
    EXPECT_NO_THROW(GetParam().run(bytes));
    // Cut anywhere, it is another input: a lost end is the commonest damage.
    for (const std::size_t part : {1, 2, 3, 5, 7}) {
      EXPECT_NO_THROW(GetParam().run(std::string_view(bytes).substr(0, bytes.size() * part / 8)));
    }
    ++n_files;
  }
  EXPECT_GT(n_files, 3);
}

INSTANTIATE_TEST_SUITE_P(Targets, Corpus, testing::ValuesIn(targets),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace stillframe::fuzz

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/run/child_process.hpp"

namespace stillframe::test {

/// What a program did: its exit code and all that it said.
struct Said {
  int exit_code = -1;
  std::string output, error;
};

/// A folder of its own for each test, with the programs at hand.
class Workspace : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  std::filesystem::path config(const std::string& file) const;
  /// Writes a file into the folder and answers its path.
  std::filesystem::path write(const std::string& file, const std::string& text) const;
  /// Starts `stillframe ARGUMENTS`; its standard error goes to the file stderr. The pictures of a
  /// `run` are drawn only after draw_pictures().
  std::unique_ptr<tools::ChildProcess> start(const std::vector<std::string>& arguments) const;
  /// Runs it to its end.
  Said run(const std::vector<std::string>& arguments) const;
  /// Runs a script of sh, in which $BIN is the folder of our programs.
  Said shell(const std::string& script) const;
  /// Processes of this network that run one of our programs or the logger.
  static std::vector<std::string> processes_left();
  /// Drawing is most of the work of a short run, and few tests look at what is drawn: others get a
  /// gnuplot that says a word for a picture. Pictures that are asked for by name, as in `sigma
  /// --plot`, are always drawn.
  void draw_pictures() { draws_pictures_ = true; }
  static std::string text_of(const std::filesystem::path& file);

  std::filesystem::path folder_;

 private:
  Said run_to_end(tools::ChildProcess& process) const;

  bool draws_pictures_ = false;
};

}  // namespace stillframe::test

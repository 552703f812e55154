#include "tests/closed_loop/workspace.hpp"

#include <unistd.h>

#include <fstream>
#include <sstream>

namespace stillframe::test {

namespace fs = std::filesystem;

void Workspace::SetUp() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::path(testing::TempDir()) /
            ("stillframe-" + std::to_string(getpid()) + "-" + info->name());
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

void Workspace::TearDown() {
  if (!HasFailure()) fs::remove_all(folder_);
}

fs::path Workspace::config(const std::string& file) const {
  return fs::path(STILLFRAME_SOURCE_DIR) / "config" / file;
}

fs::path Workspace::write(const std::string& file, const std::string& text) const {
  std::ofstream(folder_ / file) << text;
  return folder_ / file;
}

std::unique_ptr<tools::ChildProcess> Workspace::start(
    const std::vector<std::string>& arguments) const {
  std::vector<std::string> command{std::string(STILLFRAME_BIN_DIR) + "/stillframe"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return std::make_unique<tools::ChildProcess>("stillframe", command, folder_ / "stderr");
}

Said Workspace::run(const std::vector<std::string>& arguments) const {
  fs::remove(folder_ / "stderr");
  return run_to_end(*start(arguments));
}

Said Workspace::shell(const std::string& script) const {
  fs::remove(folder_ / "stderr");
  const std::string bin = "BIN='" + std::string(STILLFRAME_BIN_DIR) + "'\n";
  tools::ChildProcess process("sh", {"sh", "-c", bin + script}, folder_ / "stderr");
  return run_to_end(process);
}

Said Workspace::run_to_end(tools::ChildProcess& process) const {
  Said said;
  while (!process.exit_code()) {
    for (const std::string& line : process.read_lines()) said.output += line + "\n";
    process.wait(0.02);
  }
  for (const std::string& line : process.read_lines()) said.output += line + "\n";
  said.exit_code = *process.exit_code();
  said.error = text_of(folder_ / "stderr");
  return said;
}

std::string Workspace::text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<std::string> Workspace::processes_left() {
  const auto network = fs::read_symlink("/proc/self/ns/net");
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::error_code error;
    if (fs::read_symlink(entry.path() / "ns/net", error) != network || error) continue;
    const std::string name = text_of(entry.path() / "comm");
    if (name.starts_with("stillframe") || name.starts_with("lcm-logger")) left.push_back(name);
  }
  return left;
}

}  // namespace stillframe::test

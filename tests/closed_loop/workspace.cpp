#include "tests/closed_loop/workspace.hpp"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

namespace stillframe::test {

namespace fs = std::filesystem;

namespace {

/// Puts a folder before all others in which programs are looked for, until it goes out of scope.
class FirstInPath {
 public:
  explicit FirstInPath(const fs::path& folder) {
    setenv("PATH", (folder.string() + ":" + before_).c_str(), 1);
  }
  ~FirstInPath() { setenv("PATH", before_.c_str(), 1); }
  FirstInPath(const FirstInPath&) = delete;
  FirstInPath& operator=(const FirstInPath&) = delete;

 private:
  std::string before_ = std::getenv("PATH") != nullptr ? std::getenv("PATH") : "";
};

/// A folder with a gnuplot that draws nothing.
fs::path folder_without_pictures(const fs::path& folder) {
  const fs::path bin = folder / "no_pictures";
  if (!fs::exists(bin)) {
    fs::create_directories(bin);
    std::ofstream(bin / "gnuplot") << "#!/bin/sh\necho picture\n";
    fs::permissions(bin / "gnuplot", fs::perms::owner_all);
  }
  return bin;
}

}  // namespace

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
  std::optional<FirstInPath> path;
  if (!draws_pictures_ && !arguments.empty() && arguments.front() == "run") {
    path.emplace(folder_without_pictures(folder_));
  }
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

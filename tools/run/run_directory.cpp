#include "tools/run/run_directory.hpp"

#include <fstream>

#include "core/yaml/input_error.hpp"

namespace stillframe::tools {

RunDirectory::RunDirectory(const std::filesystem::path& name)
    : name_(name), present_(name.string() + ".incomplete") {
  if (std::filesystem::exists(name_)) {
    throw InputError(name_.string() + ": is there already; choose another folder with --out");
  }
  std::error_code error;
  std::filesystem::remove_all(present_, error);
  std::filesystem::create_directories(present_, error);
  if (error) throw InputError(present_.string() + ": cannot be made: " + error.message());
}

RunDirectory::~RunDirectory() {
  if (finished_) return;
  std::ofstream(present_ / "FAILED.txt") << failure_ << "\n";
}

void RunDirectory::write(const std::string& file, const std::string& text) const {
  std::ofstream stream(present_ / file);
  stream << text;
  stream.close();
  if (!stream) throw InputError((present_ / file).string() + ": cannot be written");
}

void RunDirectory::finish() {
  std::error_code error;
  std::filesystem::rename(present_, name_, error);
  if (error) throw InputError(name_.string() + ": cannot be given its name: " + error.message());
  finished_ = true;
}

}  // namespace stillframe::tools

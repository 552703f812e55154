#include "tools/run/run_directory.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"

namespace stillframe::tools {

namespace fs = std::filesystem;

RunDirectory::RunDirectory(const fs::path& name, Taken taken) {
  std::string plain = name.string();
  while (plain.ends_with('/')) plain.pop_back();
  if (plain.empty()) {
    throw InputError("--out: found '" + name.string() + "', allowed is a folder that is not there");
  }
  fs::path there = claim(plain);
  for (int n = 2; !there.empty() && taken == Taken::count_on; ++n) {
    there = claim(plain + "-" + std::to_string(n));
  }
  if (there.empty()) return;
  const std::string what = there == name_                     ? "is there already"
                           : fs::exists(there / "FAILED.txt") ? "is what a failed run has left"
                                                              : "is there, of another run";
  throw InputError(there.string() + ": " + what + "; choose another folder with --out" +
                   (there == name_ ? "" : ", or remove it if nothing writes to it any more"));
}

fs::path RunDirectory::claim(const std::string& name) {
  name_ = name;
  present_ = name_.string() + ".incomplete";
  std::error_code error;
  if (name_.has_parent_path()) fs::create_directories(name_.parent_path(), error);
  if (error) {
    throw InputError(name_.parent_path().string() + ": cannot be made: " + error.message());
  }
  // Whoever makes it owns it, also if two try at once.
  if (mkdir(present_.c_str(), 0777) != 0) {
    if (errno == EEXIST) return present_;
    throw InputError(present_.string() + ": cannot be made: " + std::strerror(errno));
  }
  // Behind that, because another run may just have come to its end.
  if (fs::exists(fs::symlink_status(name_, error))) {
    rmdir(present_.c_str());
    return name_;
  }
  finished_ = false;
  return {};
}

RunDirectory::~RunDirectory() {
  if (finished_) return;
  try {
    write("FAILED.txt", failure_ + "\n");
  } catch (const std::exception&) {  // the disk may be what has failed; the name still says it
  }
}

void RunDirectory::write(const std::string& file, const std::string& text) const {
  write_whole_file(present_ / file, text);
}

void RunDirectory::finish() {
  // Unlike plain renaming this does not replace an empty folder that has come in the meantime.
  int failed = renameat2(AT_FDCWD, present_.c_str(), AT_FDCWD, name_.c_str(), RENAME_NOREPLACE);
  if (failed != 0 && errno == EINVAL) failed = rename(present_.c_str(), name_.c_str());
  if (failed != 0) {
    const std::string why = std::strerror(errno);
    failure_ = name_.string() + ": cannot be given its name: " + why;
    throw OutputError(failure_ + "; the run lies in " + present_.string());
  }
  finished_ = true;
}

}  // namespace stillframe::tools

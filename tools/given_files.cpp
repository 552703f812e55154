#include "tools/given_files.hpp"

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"

namespace stillframe::tools {

namespace fs = std::filesystem;

namespace {

/// Whether what is saved under one name is gone from under the other.
bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) {
    return fs::is_regular_file(a, error) && fs::equivalent(a, b, error);
  }
  // Of a relative path that is nowhere, weakly_canonical() does not know the folder.
  const fs::path full_a = fs::weakly_canonical(fs::absolute(a, error), error);
  return !error && full_a == fs::weakly_canonical(fs::absolute(b, error), error);
}

}  // namespace

void require_own_places(const std::vector<GivenFile>& read, const std::vector<GivenFile>& written) {
  for (auto file = written.begin(); file != written.end(); ++file) {
    if (!file->path) continue;
    if (file->path->empty()) require_place(file->name, *file->path);
    for (const GivenFile& other : read) {
      if (!other.path || !is_same(*file->path, *other.path)) continue;
      throw InputError(file->name + ": " + file->path->string() + " is " + other.name +
                       " that is read");
    }
    for (auto other = written.begin(); other != file; ++other) {
      if (!other->path || !is_same(*file->path, *other->path)) continue;
      throw InputError(file->name + " and " + other->name + " are one file, " +
                       file->path->string() + "; allowed are two");
    }
    require_place(file->name, *file->path);
  }
}

}  // namespace stillframe::tools

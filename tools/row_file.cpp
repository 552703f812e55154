#include "tools/row_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>

#include "core/control/robustness/parallel.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/bytes_of_file.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "msgs/stop_signal.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr const char* check_key = "check";

std::string dumped(const Json& row) {
  return row.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Of a line, or as much of it as there is.
bool begins_as_row(const std::string& line) {
  const std::string first = R"({"version":)", begin = line.substr(0, first.size());
  return first.starts_with(begin);
}

/// Takes the check out of a row; false if it is not that of the rest.
bool take_check(Json& row) {
  const Json check = row.value(check_key, Json());
  row.erase(check_key);
  return check == text_hash(dumped(row));
}

}  // namespace

RowFile::RowFile(std::filesystem::path path, const RowKind& kind)
    : path_(std::move(path)), kind_(kind) {
  std::error_code missing;
  if (!std::filesystem::exists(path_, missing)) return;
  if (!std::filesystem::is_regular_file(path_, missing)) {
    throw InputError(path_.string() +
                     ": found something that is no file, allowed is a file that grows by rows");
  }
  const auto bytes = bytes_of_file(path_);
  if (!bytes) throw InputError(path_.string() + ": cannot be read");
  const std::string& text = *bytes;
  const auto refuse = [&](std::size_t number, const std::string& found) {
    throw InputError(path_.string() + ":" + std::to_string(number) + ": found " + found +
                     "; allowed is a file that `" + kind_.verb + " --out` wrote, or a new one");
  };
  const std::string no_row = "a line that is no row of a " + kind_.verb;
  std::size_t begin = 0, line = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    ++line;
    Json row = Json::parse(text.substr(begin, end - begin), nullptr, false);
    if (row.is_discarded() && begins_as_row(text.substr(begin))) {
      ++n_broken_;
      continue;
    }
    if (!is_row(row, kind_)) refuse(line, no_row);
    if (!take_check(row)) refuse(line, "a row that is not as it was written");
    std::string key = key_of(row);
    rows_[std::move(key)] = std::move(row);
  }
  size_ = begin;
  if (begin == text.size()) return;
  // What a killed program left, and nothing else.
  if (!begins_as_row(text.substr(begin))) refuse(line + 1, no_row);
  unfinished_ = text.size() - begin;
}

bool RowFile::is_half_a_row(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::getline(file, line);
  return file.eof() && begins_as_row(line);
}

std::string RowFile::key_of(const Json& row) const {
  std::string key;
  for (const std::string& name : kind_.identity) {
    key += nlohmann::json(row.at(name)).dump() + " ";  // sorted: in whatever order keys were given
  }
  return key;
}

const Json* RowFile::find(const Json& row) const {
  const auto known = rows_.find(key_of(row));
  return known == rows_.end() ? nullptr : &known->second;
}

bool is_row(const Json& row, const RowKind& kind) {
  const auto has = [&](const std::string& key) { return row.contains(key); };
  return row.is_object() && std::ranges::all_of(kind.identity, has) &&
         std::ranges::all_of(kind.others, has);
}

std::string line_of(const Json& row) {
  Json checked = row;
  checked[check_key] = text_hash(dumped(row));
  return dumped(checked) + "\n";
}

void RowFile::add(const Json& row) {
  std::string line = line_of(row);
  const auto fail = [&](const std::string& why) {
    throw OutputError(path_.string() + why +
                      "; the same command goes on from the rows that it has");
  };
  const int file = open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) fail(std::string(": cannot be written: ") + std::strerror(errno));
  struct stat before {};
  fstat(file, &before);
  auto size = static_cast<std::uintmax_t>(before.st_size);
  // Where the file is as it was read; another program may have taken it off and gone on.
  if (unfinished_ > 0 && size == size_ + unfinished_ &&
      ftruncate(file, static_cast<off_t>(size_)) == 0) {
    size = size_;
  }
  unfinished_ = 0;
  if (size < size_) {
    close(file);
    fail(": rows were taken out of it while it was written");
  }
  // Half a line of another program, which was killed since.
  char end = '\n';
  if (size > 0 && pread(file, &end, 1, static_cast<off_t>(size) - 1) == 1 && end != '\n') {
    line.insert(0, 1, '\n');
  }
  std::size_t written = 0;
  ssize_t part = 0;
  while (written < line.size() &&
         (part = write(file, line.data() + written, line.size() - written)) > 0) {
    written += static_cast<std::size_t>(part);
  }
  const int error = errno;
  // Half a line, if nobody else has added to it.
  struct stat after {};
  const bool whole = written == line.size();
  if (!whole && fstat(file, &after) == 0 &&
      static_cast<std::uintmax_t>(after.st_size) == size + written) {
    static_cast<void>(ftruncate(file, static_cast<off_t>(size)) == 0);
  }
  close(file);
  if (!whole) fail(std::string(": cannot be written: ") + std::strerror(error));
  size_ = size + written;
}

std::vector<Json> fill_rows(const RowStudy& study, const std::vector<std::size_t>& points, int jobs,
                            RowFile* file) {
  const std::size_t n = points.size();
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  catch_stop_signals();
  std::vector<Json> rows(n);
  Patience patience(study.things);
  std::mutex mutex;
  std::size_t n_done = 0;
  robustness::parallel_for(n, jobs > 0 ? jobs : cores, [&](std::uint64_t i, int) {
    if (stop_requested()) return;
    const Json identity = file ? study.identity(points[i]) : Json();
    const Json* known = identity.is_null() ? nullptr : file->find(identity);
    if (known && !study.answers(*known)) known = nullptr;
    Json row = known ? *known : study.compute(points[i]);
    const std::lock_guard lock(mutex);
    // What was stopped on its way is not what comes of it.
    if (stop_requested() && !known) return;
    if (file && !known) file->add(row);
    rows[i] = std::move(row);
    patience.now(study.things, 100 * static_cast<double>(++n_done) / static_cast<double>(n));
  });
  if (n_done < n) {
    throw Failure("interrupted with " + std::to_string(n - n_done) + " of " + std::to_string(n) +
                  " " + study.things + " missing" +
                  (file ? "; the same command goes on where it stopped" : ""));
  }
  return rows;
}

}  // namespace stillframe::tools

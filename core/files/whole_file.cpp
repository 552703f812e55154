#include "core/files/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "core/errors/input_error.hpp"

namespace stillframe {

namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 20;

template <class Error>
[[noreturn]] void fail(const std::filesystem::path& path) {
  throw Error(path.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace

WholeFile::WholeFile(std::filesystem::path path) : path_(std::move(path)) {
  if (path_.empty()) throw InputError("found '' to write to, allowed is the name of a file");
  std::error_code error;
  if (std::filesystem::is_symlink(path_, error)) {
    const auto target = std::filesystem::canonical(path_, error);
    // One that points to a file that is not there yet.
    path_ = error ? path_.parent_path() / std::filesystem::read_symlink(path_) : target;
  }
  beside_ =
      !std::filesystem::exists(path_, error) || std::filesystem::is_regular_file(path_, error);
  if (beside_) {
    open_beside();
  } else {
    present_ = path_;
    file_ = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  }
  if (file_ < 0) fail<InputError>(path_);
}

void WholeFile::open_beside() {
  static std::atomic<unsigned> count = 0;
  do {
    present_ = path_;
    present_ += ".incomplete-" + std::to_string(getpid()) + "-" + std::to_string(++count);
    file_ = open(present_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    // What is there already was left behind by a process of the same number that was killed.
  } while (file_ < 0 && errno == EEXIST);
}

WholeFile::~WholeFile() {
  if (file_ < 0) return;
  close(file_);
  if (beside_) unlink(present_.c_str());
}

void WholeFile::write(std::string_view bytes) {
  buffer_ += bytes;
  size_ += static_cast<std::int64_t>(bytes.size());
  if (buffer_.size() >= buffer_size) flush();
}

void WholeFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail<OutputError>(path_);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

std::int64_t WholeFile::leave(std::int64_t n_bytes) {
  flush();
  const std::int64_t offset = size_;
  size_ += n_bytes;
  if (ftruncate(file_, size_) != 0 || lseek(file_, size_, SEEK_SET) < 0) fail<OutputError>(path_);
  return offset;
}

void WholeFile::write_at(std::int64_t offset, std::string_view bytes) {
  flush();
  while (!bytes.empty()) {
    const ssize_t written = pwrite(file_, bytes.data(), bytes.size(), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail<OutputError>(path_);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
}

void WholeFile::save() {
  flush();
  // Without this a crash after the renaming can leave an empty file under the right name.
  if (beside_ && fsync(file_) != 0) fail<OutputError>(path_);
  if (beside_ && rename(present_.c_str(), path_.c_str()) != 0) fail<OutputError>(path_);
  const int file = file_;
  file_ = -1;
  if (close(file) != 0) fail<OutputError>(path_);
}

void require_place(const std::string& option, const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& why) {
    throw InputError(option + ": found '" + path.string() + "', " + why);
  };
  if (path.empty()) refuse("allowed is the name of a file");
  std::error_code error;
  const fs::file_status there = fs::status(path, error);
  if (fs::is_directory(there)) refuse("which is a folder; allowed is the name of a file");
  if (fs::exists(there) && !fs::is_regular_file(there)) return;  // a device or a pipe
  // A link stays, what it points to is replaced.
  const fs::path real = fs::is_symlink(path, error) ? fs::weakly_canonical(path, error) : path;
  const fs::path folder = real.has_parent_path() ? real.parent_path() : ".";
  if (!fs::is_directory(folder, error)) refuse("but there is no folder '" + folder.string() + "'");
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse("but nothing may be written in the folder '" + folder.string() + "'");
  }
}

void write_whole_file(const std::filesystem::path& path, std::string_view text) {
  WholeFile file(path);
  file.write(text);
  file.save();
}

}  // namespace stillframe

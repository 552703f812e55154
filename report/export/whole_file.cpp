#include "report/export/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/yaml/input_error.hpp"

namespace stillframe::report {

namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 20;

}  // namespace

WholeFile::WholeFile(std::filesystem::path path) : path_(std::move(path)), temporary_(path_) {
  temporary_ += ".incomplete-" + std::to_string(getpid());
  file_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail();
  buffer_.reserve(buffer_size);
}

WholeFile::~WholeFile() {
  if (file_ >= 0) close(file_);
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

void WholeFile::fail() const {
  throw InputError(path_.string() + ": cannot be written: " + std::strerror(errno));
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
    if (written <= 0) fail();
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void WholeFile::save() {
  flush();
  const int file = file_;
  file_ = -1;
  if (close(file) != 0) fail();
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) {
    errno = error.value();
    fail();
  }
  temporary_.clear();
}

}  // namespace stillframe::report

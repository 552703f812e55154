#include "report/log/file_window.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/errors/input_error.hpp"

namespace stillframe::report {

namespace {

/// Enough that the system calls cost nothing beside the copying.
constexpr std::int64_t read_ahead = std::int64_t{1} << 20;

}  // namespace

FileWindow::FileWindow(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError(path.string() + ": there is no such LCM log");
  }
  size_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (error || file_ < 0) {
    throw InputError(path.string() + ": the LCM log cannot be opened for reading");
  }
}

FileWindow::~FileWindow() {
  if (file_ >= 0) close(file_);
}

std::string_view FileWindow::at(std::int64_t offset, std::int64_t n) {
  n = std::clamp<std::int64_t>(n, 0, std::max<std::int64_t>(size_ - offset, 0));
  if (offset < begin_ || offset + n > begin_ + filled_) move_to(offset, n);
  // A file that was cut while it is read has less than it promised.
  n = std::clamp<std::int64_t>(n, 0, std::max<std::int64_t>(begin_ + filled_ - offset, 0));
  return {buffer_.data() + (offset - begin_), static_cast<std::size_t>(n)};
}

void FileWindow::move_to(std::int64_t offset, std::int64_t n) {
  const std::int64_t wanted = std::min(std::max(n, read_ahead), size_ - offset);
  if (static_cast<std::int64_t>(buffer_.size()) < wanted) {
    buffer_.resize(static_cast<std::size_t>(wanted));
  }
  std::int64_t kept = 0;
  if (offset >= begin_ && offset < begin_ + filled_) {
    kept = begin_ + filled_ - offset;
    std::memmove(buffer_.data(), buffer_.data() + (offset - begin_),
                 static_cast<std::size_t>(kept));
  }
  begin_ = offset;
  filled_ = kept;
  while (filled_ < wanted) {
    const ssize_t got = pread(file_, buffer_.data() + filled_,
                              static_cast<std::size_t>(wanted - filled_), begin_ + filled_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw InputError(path_.string() + ": cannot be read at byte " +
                       std::to_string(begin_ + filled_) + ": " + std::strerror(errno));
    }
    if (got == 0) break;
    filled_ += got;
  }
}

std::int64_t FileWindow::find(std::string_view bytes, std::int64_t begin, std::int64_t end) {
  end = std::min(end, size_);
  const auto length = static_cast<std::int64_t>(bytes.size());
  while (begin + length <= end) {
    const std::string_view part = at(begin, std::min(read_ahead, end - begin));
    const std::size_t found = part.find(bytes);
    if (found != std::string_view::npos) return begin + static_cast<std::int64_t>(found);
    const auto seen = static_cast<std::int64_t>(part.size());
    if (seen < length) return -1;
    begin += seen - length + 1;
  }
  return -1;
}

}  // namespace stillframe::report

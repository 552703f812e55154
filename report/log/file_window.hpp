#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace stillframe::report {

/// A file seen through a window that moves over it: only what is asked for, and some bytes ahead,
/// is in memory. Set-up. Errors: InputError if the file is none or cannot be read.
class FileWindow {
 public:
  explicit FileWindow(const std::filesystem::path& path);
  ~FileWindow();
  FileWindow(const FileWindow&) = delete;
  FileWindow& operator=(const FileWindow&) = delete;

  /// Bytes, as it was when it was opened.
  std::int64_t size() const { return size_; }

  /// The n bytes from an offset on, fewer where the file ends; valid until the next call.
  std::string_view at(std::int64_t offset, std::int64_t n);

  /// The first place in begin .. end - 1 where `bytes` stand whole, or -1.
  std::int64_t find(std::string_view bytes, std::int64_t begin, std::int64_t end);

 private:
  void move_to(std::int64_t offset, std::int64_t n);

  std::filesystem::path path_;
  int file_ = -1;
  std::int64_t size_ = 0, begin_ = 0, filled_ = 0;
  std::vector<char> buffer_;
};

}  // namespace stillframe::report

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace stillframe::report {

/// A file that is written beside its place under a temporary name and put there whole by save():
/// whoever reads it never finds half of one. Set-up. Errors of every function: InputError if the
/// file cannot be written.
class WholeFile {
 public:
  explicit WholeFile(std::filesystem::path path);
  /// Removes what was not saved.
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /// At the end.
  void write(std::string_view bytes);
  std::int64_t size() const { return size_; }
  void save();

 private:
  [[noreturn]] void fail() const;
  void flush();
  std::filesystem::path path_, temporary_;
  int file_ = -1;
  std::int64_t size_ = 0;  ///< what waits in buffer_ included
  std::string buffer_;
};

}  // namespace stillframe::report

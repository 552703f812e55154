#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stillframe {

/// The system does not take what is written: a full disk, a quota, a broken device. What was asked
/// for was sound. Programs print what() and exit with 1.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The one way in which a file is written: under a temporary name in the folder of its place, and
/// put there by save() once the disk has it all, so that whoever reads it finds an older file or
/// the whole of this one, never a part. A symbolic link stays, what it points to is replaced. What
/// is no regular file (a pipe, a device) is written to as it is. Set-up.
///
/// Errors: InputError if there can be no file of that name; OutputError of every other function.
class WholeFile {
 public:
  explicit WholeFile(std::filesystem::path path);
  /// Removes what was not saved.
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /// At the end.
  void write(std::string_view bytes);
  /// Leaves so many bytes free at the end; they are zero until write_at() fills them. Answers where
  /// they begin.
  std::int64_t leave(std::int64_t n_bytes);
  /// Over what was written or left free.
  void write_at(std::int64_t offset, std::string_view bytes);
  std::int64_t size() const { return size_; }
  /// Where it is being written, for a writer that takes a name and flushes itself.
  const std::filesystem::path& present() const { return present_; }
  void save();

 private:
  void open_beside();
  void flush();
  std::filesystem::path path_, present_;
  int file_ = -1;
  bool beside_ = true;     ///< present_ is a file of our own
  std::int64_t size_ = 0;  ///< what waits in buffer_ included
  std::string buffer_;
};

/// Before what takes minutes, and is not to be lost for want of a place: there can be a file of
/// that name. option: what asks for it. Errors: InputError "option: found 'path', ...".
void require_place(const std::string& option, const std::filesystem::path& path);

/// Such a file of one text.
void write_whole_file(const std::filesystem::path& path, std::string_view text);

}  // namespace stillframe

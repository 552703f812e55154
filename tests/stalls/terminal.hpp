#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace stillframe::stalls {

/// What becomes of what a program prints.
enum class Reader {
  none,  ///< a terminal whose output was stopped, as by Ctrl-S
  slow,  ///< a terminal of 100 characters a second
  full,  ///< a pipe that is full and that nobody reads
  gone,  ///< a pipe without a reader
  file,  ///< takes all
};

/// A place to print to that can be opened by its name. Errors: std::system_error.
class Terminal {
 public:
  /// In a folder, where it makes a pipe or a file if it needs one.
  Terminal(Reader reader, const std::filesystem::path& folder);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  const std::string& name() const { return name_; }
  /// From now on it is as its reader makes it; until then it takes what there is room for.
  void begin();

 private:
  void open_terminal();
  void open_pipe(const std::filesystem::path& pipe);
  void fill_pipe() const;
  void read_slowly();

  Reader reader_;
  std::string name_;
  int ours_ = -1, theirs_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace stillframe::stalls

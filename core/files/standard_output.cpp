#include "core/files/standard_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "core/files/printable_lines.hpp"

namespace stillframe {

namespace {

/// Gives a stream another buffer while it lives.
class Behind {
 public:
  explicit Behind(std::ostream& stream) : stream_(stream), own_(stream.rdbuf()), lines_(*own_) {
    stream_.rdbuf(&lines_);
  }
  ~Behind() {
    lines_.pubsync();
    stream_.rdbuf(own_);
  }
  Behind(const Behind&) = delete;
  Behind& operator=(const Behind&) = delete;

 private:
  std::ostream& stream_;
  std::streambuf* own_;
  PrintableLines lines_;
};

}  // namespace

int with_standard_output(const char* program, const std::function<int()>& run) {
  // Where a standard stream is closed, the next file that is opened would take its number, and what
  // is printed would go into that file. This one can only be read.
  int free = open("/dev/null", O_RDONLY | O_CLOEXEC);
  while (free >= 0 && free <= STDERR_FILENO) free = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (free >= 0) close(free);
  const Behind output(std::cout), errors(std::cerr);
  const int exit_code = run();
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  if (std::cout && flushed && std::ferror(stdout) == 0) return exit_code;
  // If it was an earlier write that failed, nobody knows any more why.
  std::cerr << program << ": error: standard output cannot be written" << (errno != 0 ? ": " : "")
            << (errno != 0 ? std::strerror(errno) : "") << "\n";
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace stillframe

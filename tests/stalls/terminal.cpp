#include "tests/stalls/terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "msgs/clock.hpp"

namespace stillframe::stalls {

namespace {

int sound(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

}  // namespace

Terminal::Terminal(Reader reader, const std::filesystem::path& folder) : reader_(reader) {
  switch (reader) {
    case Reader::none:
    case Reader::slow:
      open_terminal();
      return;
    case Reader::full:
    case Reader::gone:
      open_pipe(folder / "pipe");
      return;
    case Reader::file:
      name_ = folder / "said.txt";
  }
}

Terminal::~Terminal() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  // What waits in a stopped terminal must be thrown away, or closing it would wait.
  if (reader_ == Reader::none || reader_ == Reader::slow) tcflush(theirs_, TCIOFLUSH);
  if (theirs_ >= 0) close(theirs_);
  if (ours_ >= 0) close(ours_);
}

void Terminal::open_terminal() {
  ours_ = sound(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC), "posix_openpt");
  sound(grantpt(ours_), "grantpt");
  sound(unlockpt(ours_), "unlockpt");
  name_ = ptsname(ours_);
  theirs_ = sound(open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC), "open terminal");
}

void Terminal::open_pipe(const std::filesystem::path& pipe) {
  std::filesystem::remove(pipe);
  sound(mkfifo(pipe.c_str(), 0600), "mkfifo");
  name_ = pipe;
  // Open both ways, a pipe waits for nobody.
  ours_ = sound(open(pipe.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK), "open pipe");
}

void Terminal::fill_pipe() const {
  const std::array<char, 4096> block{};
  while (write(ours_, block.data(), block.size()) > 0) {
  }
  while (write(ours_, block.data(), 1) > 0) {
  }
}

void Terminal::begin() {
  switch (reader_) {
    case Reader::none:
      sound(tcflow(theirs_, TCOOFF), "tcflow");
      return;
    case Reader::slow:
      thread_ = std::thread([this] { read_slowly(); });
      return;
    case Reader::full:
      fill_pipe();
      return;
    case Reader::gone:
      close(ours_);
      ours_ = -1;
      return;
    case Reader::file:
      return;
  }
}

void Terminal::read_slowly() {
  while (!stop_) {
    sleep_until(monotonic_ns() + 10'000'000);
    pollfd ready{.fd = ours_, .events = POLLIN, .revents = 0};
    char character = 0;
    if (poll(&ready, 1, 0) > 0 && read(ours_, &character, 1) != 1) return;
  }
}

}  // namespace stillframe::stalls

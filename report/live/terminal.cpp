#include "report/live/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string_view>

#include "msgs/stop_signal.hpp"

namespace stillframe::live {

namespace {

// The other screen and no cursor; and back.
constexpr std::string_view enter_codes = "\033[?1049h\033[?25l\033[H\033[2J";
constexpr std::string_view leave_codes = "\033[?25h\033[?1049l";

volatile std::sig_atomic_t stop_asked = 0;

void on_stop(int) { stop_asked = 1; }

void handle(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

}  // namespace

Terminal::Terminal(int fd) : fd_(fd) {
  handle(SIGTSTP, on_stop);
  enter();
}

Terminal::~Terminal() {
  leave();
  handle(SIGTSTP, SIG_DFL);
}

void Terminal::enter() { write(std::string(enter_codes)); }
void Terminal::leave() { write(std::string(leave_codes)); }

ScreenSize Terminal::size() const {
  winsize size{};
  if (ioctl(fd_, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {80, 24};
  return {size.ws_col, size.ws_row};
}

void Terminal::show(const std::string& text) {
  std::string screen = "\033[H";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    screen += text.substr(at, end - at) + "\033[K";
    at = end + 1;
    if (at < text.size()) screen += '\n';  // one after the last line would scroll
  }
  write(screen + "\033[J");
}

void Terminal::stop_if_asked() {
  if (stop_asked == 0) return;
  stop_asked = 0;
  leave();
  raise(SIGSTOP);
  enter();
}

// What cannot be written is left out: the terminal may be gone.
void Terminal::write(const std::string& text) const {
  std::string_view rest = text;
  while (!rest.empty()) {
    const ssize_t written = ::write(fd_, rest.data(), rest.size());
    if (written < 0 && (errno != EINTR || stop_requested())) return;
    if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace stillframe::live

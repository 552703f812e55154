#pragma once

#include <string>

#include "report/live/screen.hpp"

namespace stillframe::live {

/// A terminal's other screen, written over again and again; the terminal is as it was once this is
/// gone, also by an exception, and while the program is stopped (Ctrl-Z). One at a time. Set-up.
class Terminal {
 public:
  explicit Terminal(int fd);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// What it has room for now; 80 by 24 if it does not say.
  ScreenSize size() const;
  void show(const std::string& text);
  /// Stops the program if Ctrl-Z was pressed, and comes back when it goes on.
  void stop_if_asked();

 private:
  void enter();
  void leave();
  void write(const std::string& text) const;
  int fd_;
};

}  // namespace stillframe::live

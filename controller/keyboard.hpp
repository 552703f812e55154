#pragma once

#include <termios.h>

#include <optional>

namespace stillframe::controller {

/// Single keys from a terminal, without waiting; nothing where standard input is no terminal. The
/// terminal is as before once the object is gone. Set-up.
class Keyboard {
 public:
  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  bool is_there() const { return before_.has_value(); }
  /// The next key that was pressed.
  std::optional<char> key();

 private:
  std::optional<termios> before_;
};

}  // namespace stillframe::controller

#pragma once

#include <stdexcept>
#include <string>

namespace stillframe {

/// Bad input from a person: a file, a key, a command line. what() is one message that names the
/// place
/// ("file:line:column: "), the key, what was found and what is allowed. Programs print it and exit
/// with 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A sound input that leads to something the program will not do (an unstable loop, a singular
/// model). Programs print what() and exit with 3.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace stillframe

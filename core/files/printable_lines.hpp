#pragma once

#include <streambuf>
#include <string>

namespace stillframe {

/// Stands before the buffer of a stream and lets whole lines through, made printable; only tabs
/// stay as they are. Set-up.
class PrintableLines : public std::streambuf {
 public:
  explicit PrintableLines(std::streambuf& behind) : behind_(behind) {}

 protected:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize n) override;
  int sync() override;

 private:
  bool give_line();

  std::streambuf& behind_;
  std::string line_;
};

}  // namespace stillframe

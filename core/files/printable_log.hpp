#pragma once

#include <spdlog/pattern_formatter.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>

#include "core/files/printable_lines.hpp"

namespace stillframe {

/// The text of a log message with nothing in it that a terminal would obey.
class PrintableText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& to) override {
    std::stringbuf text;
    PrintableLines lines(text);
    lines.sputn(message.payload.data(), static_cast<std::streamsize>(message.payload.size()));
    lines.pubsync();
    const std::string clean = text.str();
    to.append(clean.data(), clean.data() + clean.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintableText>();
  }
};

/// The pattern of all log messages, as spdlog::set_pattern has it, with %* for their text. Set-up.
inline void set_printable_log(const std::string& pattern) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableText>('*').set_pattern(pattern);
  spdlog::set_formatter(std::move(formatter));
}

}  // namespace stillframe

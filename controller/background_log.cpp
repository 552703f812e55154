#include "controller/background_log.hpp"

#include <spdlog/details/log_msg_buffer.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <utility>

namespace stillframe::controller {

namespace {

/// What only the background thread touches.
struct Terminal {
  spdlog::sinks::stderr_color_sink_st lines;
  std::int64_t told_dropped = 0;
};

class BackgroundSink : public spdlog::sinks::sink {
 public:
  explicit BackgroundSink(Background& background) : background_(background) {}

  void log(const spdlog::details::log_msg& line) override {
    background_.give([terminal = terminal_, line = spdlog::details::log_msg_buffer(line),
                      n_dropped = background_.n_dropped()] {
      if (n_dropped > terminal->told_dropped) {
        const std::string text =
            std::to_string(n_dropped - terminal->told_dropped) + " lines found no room here";
        terminal->told_dropped = n_dropped;
        terminal->lines.log({line.logger_name, spdlog::level::warn, text});
      }
      terminal->lines.log(line);
    });
  }
  void flush() override {}
  void set_pattern(const std::string& pattern) override { terminal_->lines.set_pattern(pattern); }
  void set_formatter(std::unique_ptr<spdlog::formatter> formatter) override {
    terminal_->lines.set_formatter(std::move(formatter));
  }

 private:
  Background& background_;
  std::shared_ptr<Terminal> terminal_ = std::make_shared<Terminal>();
};

}  // namespace

void log_in_background(const char* name, Background& background) {
  auto logger =
      std::make_shared<spdlog::logger>(name, std::make_shared<BackgroundSink>(background));
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace stillframe::controller

#include "tools/run/phase.hpp"

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"
#include "tools/run/child_process.hpp"
#include "tools/run/progress_bar.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr std::int64_t ms = 1'000'000;

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

/// What a process said last that is an error, or else what another one did: all write into one
/// file. Of the logger, which names no levels, any line.
std::string last_error(const std::filesystem::path& file, const std::string& process) {
  std::ifstream stream(file);
  std::string line, own, other, unnamed;
  while (std::getline(stream, line)) {
    const bool is_error = line.find(": error: ") != std::string::npos;
    const std::string name = "stillframe-" + line.substr(0, line.find(':'));
    if (is_error) (name == process ? own : other) = line;
    if (!line.empty() && name != "stillframe-plant" && name != "stillframe-controller") {
      unnamed = line;
    }
  }
  return !own.empty() ? own : !other.empty() ? other : unnamed;
}

/// What the system has against a longer log, which lcm-logger does not say: tried beside the log,
/// in a file that is never saved. Empty: nothing.
std::string why_unwritable(const std::filesystem::path& log) {
  try {
    const auto size = static_cast<std::int64_t>(size_of(log));
    WholeFile beside(log);
    beside.leave(size);
    // More than a logger has at hand when it fails.
    beside.write_at(size, std::string(1 << 16, ' '));
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

class Phase {
 public:
  Phase(const PhaseOptions& options, const RunDirectory& directory)
      : options_(options),
        log_(directory / (options.loop + ".lcm")),
        text_(directory / (options.loop + ".txt")),
        timing_(directory / (options.loop + "_timing.json")) {}

  PhaseResult run() {
    start_logger();
    start_controller();
    start_plant();
    PhaseResult result = watch();
    plant_->stop();
    controller_->stop();
    for (const std::string& line : controller_->read_lines()) result.controller_line = line;
    let_logger_finish();
    logger_->stop();
    return result;
  }

 private:
  /// The first messages would be lost if the logger were not listening yet, so it is asked until it
  /// writes.
  void start_logger() {
    logger_ = std::make_unique<ChildProcess>(
        "lcm-logger",
        std::vector<std::string>{"lcm-logger", "--quiet", "--force", "--flush-interval=1",
                                 "--lcm-url=" + options_.lcm_url, log_.string()},
        text_);
    const auto lcm = open_lcm(options_.lcm_url);
    const std::int64_t begin = monotonic_ns();
    while (size_of(log_) == 0) {
      if (logger_->exit_code() == 127) {
        throw InputError(
            "lcm-logger is not installed; scripts/setup installs it (Debian: liblcm-bin)");
      }
      if (logger_->exit_code() || monotonic_ns() - begin > 10'000 * ms) {
        throw InputError("lcm-logger does not write: " + last_error(text_, "lcm-logger"));
      }
      lcm->publish(channels::logger_check, "", 0);
      sleep_until(monotonic_ns() + 20 * ms);
    }
  }

  void start_controller() {
    std::vector<std::string> command{(program_folder() / "stillframe-controller").string(),
                                     "--gains",
                                     options_.gains.string(),
                                     "--run-id",
                                     std::to_string(options_.run_id),
                                     "--lcm-url",
                                     options_.lcm_url,
                                     "--timeout",
                                     std::to_string(options_.timeout_s)};
    const auto add = [&](const char* option, const std::string& value) {
      command.insert(command.end(), {option, value});
    };
    if (options_.policy) add("--policy", options_.policy->string());
    if (options_.realtime) add("--realtime", *options_.realtime);
    if (options_.mode == "wall_clock") {
      add("--timing", timing_.string());
      add("--flight-folder", timing_.parent_path().string());
      // Of this run alone: what it simulates is broken nowhere else.
      add("--latch", (timing_.parent_path() / "latch.yaml").string());
    }
    controller_ = std::make_unique<ChildProcess>("stillframe-controller", command, text_);
  }

  void start_plant() {
    std::vector<std::string> command{(program_folder() / "stillframe-plant").string(),
                                     options_.scene.string(),
                                     "--gains",
                                     options_.gains.string(),
                                     "--mode",
                                     options_.mode,
                                     "--loop",
                                     options_.loop,
                                     "--run-id",
                                     std::to_string(options_.run_id),
                                     "--lcm-url",
                                     options_.lcm_url,
                                     "--timeout",
                                     std::to_string(options_.timeout_s),
                                     "--progress",
                                     "--pace-by-log",
                                     log_.string()};
    const auto add = [&](const char* option, const std::string& value) {
      command.insert(command.end(), {option, value});
    };
    // Below the controller, and above whatever else the machine does.
    if (options_.realtime.value_or("") != "off") add("--priority", "40");
    add("--scene-folder", options_.scene_folder.string());
    add("--controller-folder", options_.controller_folder.string());
    add("--floor-folder", options_.floor_folder.string());
    if (options_.floor) add("--floor", options_.floor->string());
    if (options_.controller) add("--controller", options_.controller->string());
    if (options_.duration_s) {
      std::ostringstream text;
      text.precision(17);
      text << *options_.duration_s;
      add("--duration", text.str());
    }
    plant_ = std::make_unique<ChildProcess>("stillframe-plant", command, text_);
  }

  PhaseResult watch() {
    ProgressBar bar(options_.loop, options_.sample_rate_hz);
    while (true) {
      show_progress(bar);
      if (stop_requested()) return {exit_failed, "interrupted", ""};
      if (const auto code = logger_->exit_code()) return died(*logger_, *code);
      if (const auto code = plant_->exit_code())
        return *code == 0 ? let_controller_finish() : died(*plant_, *code);
      if (const auto code = controller_->exit_code()) {
        // The plant tells the end to the controller, which may be the first of the two to leave.
        const auto plant = plant_->wait(2.0);
        if (!plant || *plant != 0 || *code != 0) return died(*controller_, *code);
        return {};
      }
      sleep_until(monotonic_ns() + 20 * ms);
    }
  }

  void show_progress(ProgressBar& bar) {
    for (const std::string& line : plant_->read_lines()) {
      long long done = 0, all = 0;
      if (std::sscanf(line.c_str(), "progress %lld %lld", &done, &all) == 2) bar.show(done, all);
    }
  }

  PhaseResult let_controller_finish() {
    const auto code = controller_->wait(5.0);
    if (!code) return {exit_failed, "stillframe-controller did not end with the plant", ""};
    return *code == 0 ? PhaseResult{} : died(*controller_, *code);
  }

  PhaseResult died(ChildProcess& process, int code) {
    std::string reason = process.name() + " ended with code " + std::to_string(code);
    const bool known = code == exit_bad_input || code == exit_refused;
    std::string said = known ? "" : why_unwritable(log_);
    if (said.empty()) said = last_error(text_, process.name());
    if (!said.empty()) reason += " (" + said + ")";
    return {known ? code : exit_failed, reason, ""};
  }

  /// The logger writes behind the bus; it has finished when its file has not grown for a while.
  void let_logger_finish() {
    std::uintmax_t size = size_of(log_);
    for (int still = 0; still < 5;) {
      sleep_until(monotonic_ns() + 40 * ms);
      const std::uintmax_t now = size_of(log_);
      still = now == size ? still + 1 : 0;
      size = now;
    }
  }

  const PhaseOptions& options_;
  std::filesystem::path log_, text_, timing_;
  std::unique_ptr<ChildProcess> logger_, controller_, plant_;
};

}  // namespace

PhaseResult run_phase(const PhaseOptions& options, const RunDirectory& directory) {
  return Phase(options, directory).run();
}

}  // namespace stillframe::tools

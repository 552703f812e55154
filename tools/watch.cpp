#include <sys/resource.h>
#include <unistd.h>

#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "core/mechanics/scene/scene_reader.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"
#include "report/live/listener.hpp"
#include "report/live/live_json.hpp"
#include "report/live/page_server.hpp"
#include "report/live/screen.hpp"
#include "report/live/terminal.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr int default_port = 8765;
// Without a terminal, and of one view: time for the slow messages to come by.
constexpr double once_s = 2;
constexpr int niceness = 10;

struct WatchOptions {
  std::string lcm_url;
  std::optional<std::filesystem::path> scene;
  std::optional<std::int64_t> run_id;
  std::optional<double> duration_s;
  std::optional<int> port;
  bool once = false, json = false;
};

live::RunNames names_of(const Scene& scene) {
  live::RunNames names;
  names.source = live::RunNames::Source::scene;
  for (const auto& signal : scene.inputs) names.floor.push_back(signal.name);
  for (const auto& signal : scene.outputs) names.frame.push_back(signal.name);
  for (const auto& signal : scene.monitors) names.frame.push_back(signal.name);
  for (const auto& comparison : scene.comparisons) {
    names.axes.push_back({comparison.name, comparison.floor, comparison.frame});
  }
  if (scene.controller) {
    names.legs = scene.controller->legs;
    names.force_limit_n = scene.controller->force_limit_n;
  }
  return names;
}

/// What is done with a view: onto a terminal, line by line, or to browsers.
class Watch {
 public:
  explicit Watch(const WatchOptions& options)
      : options_(options), url_(lcm_url(options.lcm_url)), listener_(url_, settings(options)) {
    // Of this thread and those that it starts from here on: whatever is watched comes first. The
    // one that hears has little to do, and what it misses is gone.
    setpriority(PRIO_PROCESS, 0, niceness);
    if (options.port) serve(*options.port);
    const bool terminal = isatty(STDOUT_FILENO) != 0 && !options.json && !options.once;
    if (terminal && !page_) terminal_.emplace(STDOUT_FILENO);
  }

  int run() {
    const std::int64_t began = monotonic_ns();
    const auto end = options_.duration_s ? options_.duration_s
                     : options_.once     ? std::optional(once_s)
                                         : std::nullopt;
    const std::int64_t end_ns =
        end ? began + static_cast<std::int64_t>(*end * 1e9) : std::int64_t{-1};
    const std::int64_t period = (page_ ? 400 : terminal_ ? 500 : 1000) * ms;
    for (std::int64_t next = began + period; !stop_requested(); next += period) {
      const bool last = end_ns >= 0 && next >= end_ns;
      if (!wait_until(last ? end_ns : next)) break;
      if (!options_.once || last) show();
      if (last || !std::cout) break;
    }
    return leave();
  }

 private:
  static live::WatchSettings settings(const WatchOptions& options) {
    live::WatchSettings settings{.run_id = options.run_id, .names = {}};
    if (options.scene) settings.names = names_of(read_scene(*options.scene));
    return settings;
  }

  void serve(int port) {
    page_.emplace(port);
    std::cout << "live page: http://127.0.0.1:" << page_->port() << "  (Ctrl-C ends it)"
              << std::endl;
  }

  /// False if Ctrl-C came first.
  bool wait_until(std::int64_t time_ns) {
    while (!stop_requested()) {
      if (terminal_) terminal_->stop_if_asked();
      const std::int64_t left = time_ns - monotonic_ns();
      if (left <= 0) return true;
      usleep(static_cast<useconds_t>(std::min(left, 100 * ms) / 1000 + 1));
    }
    return false;
  }

  void show() {
    view_ = live::look(listener_.heard(), url_, monotonic_ns());
    if (page_) {
      page_->publish(live::to_json(*view_, true));
      if (!options_.json) return;
    }
    if (options_.json) {
      const std::int64_t now = monotonic_ns();
      if (page_ && now - printed_ns_ < 1000 * ms) return;
      printed_ns_ = now;
      std::cout << live::to_json(*view_, false) << std::endl;
    } else if (terminal_) {
      const live::ScreenSize size = terminal_->size();
      terminal_->show(live::to_text(*view_, size, true));
    } else {
      const bool first = printed_ns_ == 0;
      printed_ns_ = monotonic_ns();
      std::cout << (first ? "" : "\n") << live::to_text(*view_, {.width = 120, .height = 0}, false)
                << std::flush;
    }
  }

  int leave() {
    terminal_.reset();
    if ((options_.duration_s || options_.once) && !stop_requested()) {
      if (!view_ || view_->channels.empty()) {
        throw Failure("nothing heard on " + url_ + "; a run must be going on, in the same network");
      }
    }
    return exit_done;
  }

  const WatchOptions& options_;
  std::string url_;
  live::Listener listener_;
  std::optional<live::PageServer> page_;
  std::optional<live::Terminal> terminal_;
  std::optional<live::LiveView> view_;
  std::int64_t printed_ns_ = 0;
};

int run(const WatchOptions& options) {
  catch_stop_signals();
  return Watch(options).run();
}

}  // namespace

void add_watch(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  cli::Command verb = app.verb(
      "watch", "Watch a run while it goes on: levels, forces, state, late and lost; only listens");
  verb.option("--lcm-url", options->lcm_url,
              "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
              "udpm://239.255.76.67:7667?ttl=0)")
      .type_name("URL");
  verb.option("--scene", options->scene,
              "Names and comparisons for a run that began before the watch")
      .type_name("FILE");
  verb.option("--run-id", options->run_id, "Watch this run only (default: the newest)")
      .type_name("ID");
  verb.option("--duration", options->duration_s, "End after so long (default: at Ctrl-C)")
      .check(cli::positive_number())
      .type_name("S");
  verb.flag("--once", options->once, "Listen for --duration (default 2 s), then show it once");
  verb.flag("--json", options->json, "Print a line of JSON a second");
  verb.option("--serve", options->port,
              "Serve the live page on http://127.0.0.1:PORT, to this machine only (default " +
                  std::to_string(default_port) + "; 0: any free port)")
      .optional_value()
      .default_text(std::to_string(default_port))
      .check(cli::whole_number(0, 65535))
      .type_name("[PORT]");
  verb.footer(
      "Attach and detach at any time: it publishes nothing, and computes at nice 10. Of a run "
      "that\n"
      "began before, only what is still said is known: names are numbers without --scene.\n"
      "What each line and key means: docs/live.md.\n"
      "Keys of --json: format, watched_s, notes, run, controller, window_s, compared, axes,\n"
      "force_limit_n, legs, n_missed, channels, timing.\n"
      "Exit codes: 0 done; 2 bad usage or input; 4 nothing heard (with --once or --duration).\n"
      "Example: stillframe watch --serve");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

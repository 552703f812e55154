#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/live/live_view.hpp"
#include "report/table.hpp"

namespace stillframe::live {

namespace {

using report::count;

constexpr double quiet_s = 1;

class Notes {
 public:
  Notes(const BusWatcher& watcher, const LiveView& view, const std::string& url,
        std::int64_t now_ns)
      : watcher_(watcher), view_(view), url_(url), now_ns_(now_ns) {}

  std::vector<std::string> make() {
    if (view_.run) {
      say_of_plant();
      say_of_controller();
      say_of_samples();
      say_of_names();
    } else {
      say_of_silence();
    }
    say_of_others();
    say_of_messages();
    return std::move(notes_);
  }

 private:
  void say(std::string note) { notes_.push_back(std::move(note)); }

  void say_of_silence() {
    if (view_.channels.empty()) {
      say(formatted("nothing heard for %.0f s on ", view_.watched_s) + url_ +
          "; is a run going on, and in the same network (scripts/private_network)?");
    } else {
      say("no run heard yet, only other messages");
    }
  }

  void say_of_plant() {
    const RunView& run = *view_.run;
    if (watcher_.run()->over()) {
      say("the run is over (" + run.state + "); what is shown was its end");
    } else if (run.seq < 0) {
      say(formatted("no measurement of run %lld yet", count(run.run_id)));
    } else if (run.quiet_s > quiet_s) {
      say(formatted("no measurement for %.0f s: the plant has stopped or is gone", run.quiet_s));
    }
    const WatchedRun& watched = *watcher_.run();
    if (watched.n_before > 0) {
      say(formatted(
          "the plant of this run came back: %lld samples were heard of the one before and are "
          "no longer shown, %lld of this one",
          count(watched.n_before), count(watched.n_measured)));
    }
  }

  void say_of_controller() {
    const auto& state = watcher_.run()->controller_state;
    if (state && state->state == stillframe_msgs::run_state_t::FAILED) {
      say("the controller has failed" + (state->text.empty() ? "" : ": " + state->text));
    }
    if (!view_.controller) {
      const bool wall_clock = view_.run->mode == "wall_clock";
      const bool long_enough = now_ns_ - watcher_.run()->first_heard_ns > 2'000'000'000;
      if (wall_clock && long_enough && !watcher_.run()->over()) {
        say("no controller of this run says anything, though it goes by the clock");
      }
      return;
    }
    const ControllerView& controller = *view_.controller;
    if (controller.latched) {
      say("the controller is in a latched fault (" + controller.fault +
          "); `stillframe ctl reset` clears it");
    }
    if (controller.quiet_s > quiet_s && !watcher_.run()->over()) {
      say(formatted("the controller has said nothing for %.0f s", controller.quiet_s));
    }
    if (controller.n_controllers > 1) {
      say(formatted("%d controllers serve this run", controller.n_controllers));
    }
  }

  void say_of_samples() {
    if (!watcher_.run()->samples) return;
    const RunSamples& samples = *watcher_.run()->samples;
    if (samples.missed_lately()) {
      say(
          formatted("%lld measurements never came here; that says nothing of the controller, which "
                    "counts its own",
                    count(samples.n_missed())));
    }
    if (samples.began_anew()) say("a gap in the measurements: the levels begin anew after it");
    if (samples.n_not_finite() > 0) {
      say(formatted("%lld values were not finite, the ones before them stand in for them",
                    count(samples.n_not_finite())));
    }
    if (samples.sample_rate_hz() == 0 && samples.seq() > 0) {
      say("the sample rate is not known: the times in the measurements do not tell it");
    }
  }

  void say_of_names() {
    const WatchedRun& run = *watcher_.run();
    if (run.names.source == RunNames::Source::none && run.samples) {
      say("no run_info heard, which a lock-step run gives only at its beginning: names are "
          "numbers, and nothing is compared (--scene FILE gives both)");
    }
    if (!run.names.note.empty()) say(run.names.note);
    const bool described = run.names.source != RunNames::Source::none;
    if (described && run.samples && !view_.compared) {
      say("the scene compares nothing (key compare): every signal is shown by itself");
    }
  }

  void say_of_others() {
    if (watcher_.other_run_ns() < 0 || now_ns_ - watcher_.other_run_ns() > 5'000'000'000) return;
    say(formatted("another run is heard as well, %lld (--run-id chooses)",
                  count(watcher_.other_run())));
  }

  void say_of_messages() {
    for (const ChannelView& channel : view_.channels) {
      if (channel.n_broken > 0) {
        say(formatted("%lld damaged messages on ", count(channel.n_broken)) + channel.name);
      }
      if (channel.n_other_version > 0) {
        say(formatted("%lld messages of another version of the type on ",
                      count(channel.n_other_version)) +
            channel.name);
      }
      if (channel.n_wrong_size > 0) {
        say(formatted("%lld messages of another size on ", count(channel.n_wrong_size)) +
            channel.name);
      }
    }
  }

  const BusWatcher& watcher_;
  const LiveView& view_;
  const std::string& url_;
  std::int64_t now_ns_;
  std::vector<std::string> notes_;
};

}  // namespace

std::vector<std::string> notes_on(const BusWatcher& watcher, const LiveView& view,
                                  const std::string& url, std::int64_t now_ns) {
  return Notes(watcher, view, url, now_ns).make();
}

}  // namespace stillframe::live

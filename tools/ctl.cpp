#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "controller/supervisor.hpp"
#include "core/errors/formatted.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/clock_bus.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "report/table.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "tools/json.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using stillframe_msgs::control_request_t;
using stillframe_msgs::controller_status_t;

constexpr std::int64_t repeat_ns = 100'000'000;  // of a request, because a datagram may get lost
constexpr double next_status_s = 0.3;            // a controller says something every 0.1 s

struct CtlOptions {
  std::string action, lcm_url;
  std::int64_t run_id = 0;
  double timeout_s = 2;
  bool json = false;
};

/// What is heard of controllers, and what the one that answers says last.
class Listener {
 public:
  /// run_id: 0 for any; own: a number of this process; asks: whether it is the nonce of a request
  /// that is to be answered, or any status will do.
  Listener(lcm::LCM& lcm, std::int64_t run_id, std::int64_t own, bool asks)
      : lcm_(lcm), run_id_(run_id), own_(own), nonce_(asks ? own : 0), clocks_(own) {
    lcm.subscribe(channels::status, &Listener::on_status, this);
    lcm.subscribe(channels::clock, &Listener::on_clock, this);
  }

  /// Asks those who were heard for clocks that are not known.
  void ask() { ask_clocks(lcm_, clocks_); }

  const std::optional<controller_status_t>& answer() const { return answer_; }
  int n_answers() const { return n_answers_; }
  std::string unanswered() const { return clocks_.unanswered(); }
  /// The last status that was no answer.
  const std::optional<controller_status_t>& other() const { return other_; }
  /// The last run of another number that somebody on another clock spoke of, or a recording.
  std::optional<std::int64_t> elsewhere() const { return elsewhere_; }

 private:
  void on_status(const lcm::ReceiveBuffer* buffer, const std::string&) {
    controller_status_t status;
    if (!decode(*buffer, status)) return;
    const bool fits =
        answer_ ? status.instance == answer_->instance : run_id_ == 0 || status.run_id == run_id_;
    // Of many that are not meant, on other clocks, each would take a place from the one that is.
    if (!fits && !on_one_clock(status.instance, own_)) {
      elsewhere_ = status.run_id;
      return;
    }
    // A recording of a controller is none.
    if (!clocks_.is_fresh(status.instance, status.sent_ns, monotonic_ns())) return;
    const bool answers = fits && (nonce_ == 0 || status.nonce == nonce_);
    n_answers_ += answers ? 1 : 0;
    (answers ? answer_ : other_) = std::move(status);
  }

  void on_clock(const lcm::ReceiveBuffer* buffer, const std::string&) {
    take_clock(lcm_, clocks_, *buffer);
  }

  lcm::LCM& lcm_;
  std::int64_t run_id_, own_, nonce_;
  PeerClocks clocks_;
  std::optional<controller_status_t> answer_, other_;
  std::optional<std::int64_t> elsewhere_;
  int n_answers_ = 0;
};

std::int32_t number_of(const std::string& action) {
  if (action == "start") return control_request_t::START;
  if (action == "stop") return control_request_t::STOP;
  return control_request_t::RESET;
}

std::string nobody(const CtlOptions& options, const std::string& url, const Listener& listener) {
  const std::string within = formatted(" within %g s", options.timeout_s);
  if (!listener.other() && listener.elsewhere()) {
    return "no controller of run " + std::to_string(options.run_id) + " heard" + within +
           ", only of run " + std::to_string(*listener.elsewhere()) +
           ", on another host or recorded" + listener.unanswered();
  }
  if (!listener.other()) {
    return "no controller heard" + within + " on " + url +
           "; a controller says something of itself in wall-clock runs only, and must be in the "
           "same network" +
           listener.unanswered();
  }
  const std::string heard = std::to_string(listener.other()->run_id);
  if (options.run_id != 0 && listener.other()->run_id != options.run_id) {
    return "no controller of run " + std::to_string(options.run_id) + " heard" + within +
           ", only one of run " + heard;
  }
  return "the controller of run " + heard + " did not take the request" + within;
}

/// Listens until so many statuses have answered or the time is over; asks meanwhile.
void listen(lcm::LCM& lcm, Listener& listener, control_request_t request, int n_answers,
            double most_s) {
  const std::int64_t began = monotonic_ns();
  const std::int64_t end = began + std::llround(most_s * 1e9);
  std::int64_t next = began;
  for (std::int64_t now = began; now < end && listener.n_answers() < n_answers;
       now = monotonic_ns()) {
    if (now >= next) {
      request.sent_ns = now;
      if (request.nonce != 0 && !listener.answer()) lcm.publish(channels::request, &request);
      next = now + repeat_ns;
    }
    handle_one(lcm, static_cast<int>((std::min(next, end) - now) / 1'000'000) + 1);
    listener.ask();
  }
}

controller_status_t ask(const CtlOptions& options) {
  const std::string url = lcm_url(options.lcm_url);
  const auto lcm = open_lcm(url);
  require_hearing(*lcm);
  const bool asks = options.action != "status";
  const std::int64_t own = new_instance();
  const control_request_t request{.run_id = options.run_id,
                                  .nonce = asks ? own : 0,
                                  .asked_ns = monotonic_ns(),
                                  .sent_ns = 0,
                                  .request = asks ? number_of(options.action) : 0};
  Listener listener(*lcm, options.run_id, own, asks);
  listen(*lcm, listener, request, 1, options.timeout_s);
  // The status that takes the request is older than what comes of it; the next one is not.
  if (asks && listener.answer() && listener.answer()->answer.empty()) {
    listen(*lcm, listener, request, 2, next_status_s);
  }
  if (listener.answer()) return *listener.answer();
  throw Failure(nobody(options, url, listener));
}

std::string state_of(const controller_status_t& status) {
  return std::string(to_text(static_cast<controller::State>(status.state)));
}

std::string fault_of(const controller_status_t& status) {
  return std::string(to_text(static_cast<controller::Fault>(status.fault)));
}

Json to_json(const controller_status_t& status) {
  return {{"run_id", std::to_string(status.run_id)},
          {"instance", std::to_string(status.instance)},
          {"pid", status.pid},
          {"started_ns", status.started_ns},
          {"state", state_of(status)},
          {"fault", fault_of(status)},
          {"latched", status.latched != 0},
          {"text", status.text},
          {"answer", status.answer},
          {"n_periods", status.n_periods},
          {"n_late", status.n_late},
          {"n_lost", status.n_lost},
          {"n_duplicate", status.n_duplicate},
          {"n_missing", status.n_missing},
          {"n_saturated", status.n_saturated},
          {"n_faults", status.n_faults},
          {"n_rejoins", status.n_rejoins},
          {"n_bad_messages", status.n_bad_messages},
          {"n_commands_dropped", status.n_commands_dropped},
          {"n_records_dropped", status.n_records_dropped},
          {"n_page_faults", status.n_page_faults},
          {"worst_wake_up_us", static_cast<double>(status.worst_wake_up_ns) / 1e3},
          {"worst_compute_us", static_cast<double>(status.worst_compute_ns) / 1e3}};
}

std::string to_text(const controller_status_t& status) {
  const auto count = [](std::int64_t n) { return static_cast<long long>(n); };
  std::string text =
      formatted("run %lld, controller process %d\n", count(status.run_id), status.pid);
  text += "state        " + state_of(status) + "\n";
  text += "last fault   " + fault_of(status) +
          (status.latched ? ", latched until `stillframe ctl reset`" : "") + "\n";
  if (!status.text.empty() && status.text != state_of(status))
    text += "in words     " + status.text + "\n";
  text += formatted("periods      %lld, %lld late, %lld without a measurement, %lld limited\n",
                    count(status.n_periods), count(status.n_late), count(status.n_missing),
                    count(status.n_saturated));
  text += formatted("samples      %lld lost, %lld duplicate, %lld bad messages\n",
                    count(status.n_lost), count(status.n_duplicate), count(status.n_bad_messages));
  text += formatted("faults       %lld, %lld rejoined\n", count(status.n_faults),
                    count(status.n_rejoins));
  text += formatted("dropped      %lld commands, %lld records\n", count(status.n_commands_dropped),
                    count(status.n_records_dropped));
  text +=
      formatted("worst        wake-up %.1f us, compute %.1f us, %lld page faults\n",
                static_cast<double>(status.worst_wake_up_ns) / 1e3,
                static_cast<double>(status.worst_compute_ns) / 1e3, count(status.n_page_faults));
  return text;
}

int run(const CtlOptions& options) {
  const controller_status_t status = ask(options);
  if (options.json) {
    print(to_json(status));
  } else {
    std::cout << to_text(status);
  }
  if (options.action == "status" || status.answer.empty()) return exit_done;
  std::cerr << "stillframe: refused: " << status.answer << "\n";
  return exit_refused;
}

}  // namespace

void add_ctl(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<CtlOptions>();
  cli::Command verb = app.verb(
      "ctl", "Ask the controller of a wall-clock run to start, to stop, for a reset or its status");
  verb.option("action", options->action,
              "start: arm and take hold; stop: ramp out; reset: clear a latched fault; "
              "status: only listen")
      .required()
      .check(cli::one_of({"start", "stop", "reset", "status"}))
      .type_name("ACTION");
  verb.option("--run-id", options->run_id, "Run of the controller (default: any that is heard)")
      .check(cli::positive_number())
      .type_name("ID");
  verb.option("--lcm-url", options->lcm_url,
              "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
              "udpm://239.255.76.67:7667?ttl=0)")
      .type_name("URL");
  verb.option("--timeout", options->timeout_s, "Seconds to wait for an answer")
      .check(cli::positive_number())
      .show_default();
  verb.flag("--json", options->json, "Print the status as JSON");
  verb.footer(
      "Prints what the controller says of itself after it has taken the request, or says next.\n"
      "A reset leads to idle; start takes hold again. States, faults and the policy behind them "
      "are in\n"
      "docs/safety.md.\n"
      "Keys of --json: run_id and instance (texts), pid, started_ns, state, fault, latched, text, "
      "answer "
      "(why it\n"
      "refused, empty if it did not); the counters n_periods, n_late, n_lost, n_duplicate, "
      "n_missing,\n"
      "n_saturated, n_faults, n_rejoins, n_bad_messages, n_commands_dropped, n_records_dropped,\n"
      "n_page_faults; worst_wake_up_us, worst_compute_us.\n"
      "Exit codes: 0 done; 2 bad usage; 3 the controller refused; 4 no controller heard.\n"
      "Example: stillframe ctl stop");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

// What the log of a long wall-clock run says of the controller's own closing counters: scripts/soak
// runs it. Everything is counted from the records of the loop (SF_LOOP), the measurements, the
// commands and the last status in the log.
#include <cstring>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "controller/policy.hpp"
#include "core/cli/command.hpp"
#include "msgs/channels.hpp"
#include "report/log/log_events.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace {

using namespace stillframe;
using namespace stillframe_msgs;

struct Options {
  std::string log;
  std::int64_t memory_first_kb = 0, memory_last_kb = 0, memory_allowed_kb = 0;
  bool locked = false, json = false;
};

struct Counts {
  std::int64_t n_samples = 0, n_measurements = 0, n_commands = 0, n_records = 0;
  std::int64_t n_late = 0, n_answered = 0, n_sent = 0, n_records_missing = 0;
  std::int64_t last_period = -1;
  std::int64_t n_strange_commands = 0, n_unlogged_commands = 0, n_strange_answers = 0;
  std::optional<timing_t> closing;
  std::optional<controller_status_t> status;
};

std::uint64_t hash(const std::vector<double>& values, std::int64_t seq = 0) {
  std::uint64_t sum = 14695981039346656037U ^ static_cast<std::uint64_t>(seq);
  for (const double value : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    sum = (sum ^ bits) * 1099511628211U;
  }
  return sum;
}

/// Measurements and commands may stand in the log before or after the record that names them, so
/// they are kept by their bits until both are there.
class Reader {
 public:
  explicit Reader(const std::string& log) {
    const auto damage =
        report::for_each_event(log, [this](const report::LogEvent& event) { take(event); });
    n_damaged_ = damage.n_damaged;
    compare();
  }
  const Counts& counts() const { return counts_; }
  std::int64_t n_damaged() const { return n_damaged_; }

 private:
  void take(const report::LogEvent& event) {
    if (event.channel == channels::measurement) take_measurement(event.payload);
    if (event.channel == channels::command) take_command(event.payload);
    if (event.channel == channels::loop) take_records(event.payload);
    if (event.channel == channels::run_info) {
      run_info_t info;
      if (decode(event.payload, info)) counts_.n_samples = info.n_samples;
    }
    if (event.channel == channels::timing) {
      timing_t timing;
      if (decode(event.payload, timing) && timing.source == "controller") counts_.closing = timing;
    }
    if (event.channel == channels::status) {
      controller_status_t status;
      if (decode(event.payload, status)) counts_.status = status;
    }
  }

  void take_measurement(std::string_view payload) {
    measurement_t m;
    if (decode(payload, m)) sigma_.emplace(m.seq, hash(m.sigma));
  }

  void take_command(std::string_view payload) {
    command_t command;
    if (!decode(payload, command)) return;
    ++counts_.n_commands;
    commands_.insert(hash(command.force, command.seq));
    command_seqs_.insert(command.seq);
  }

  void take_records(std::string_view payload) {
    loop_records_t message;
    if (!decode(payload, message)) return;
    for (const loop_record_t& record : message.records) {
      ++counts_.n_records;
      counts_.n_late += record.n_elapsed - 1;
      const std::int64_t first_covered = record.period - record.n_elapsed + 1;
      counts_.n_records_missing += first_covered - counts_.last_period - 1;
      counts_.last_period = record.period;
      if (record.sent) ++counts_.n_sent;
      // Without a measurement the command's number is the loop's own, which the record lacks.
      if (record.defect != static_cast<std::int32_t>(controller::Defect::none)) continue;
      ++counts_.n_answered;
      answered_.emplace(record.seq, hash(record.sigma));
      if (record.sent) sent_.emplace(record.seq, hash(record.force, record.seq));
    }
  }

  void compare() {
    counts_.n_measurements = static_cast<std::int64_t>(sigma_.size());
    for (const auto& [seq, bits] : sent_) {
      if (commands_.contains(bits)) continue;
      ++(command_seqs_.contains(seq) ? counts_.n_strange_commands : counts_.n_unlogged_commands);
    }
    for (const auto& [seq, bits] : answered_) {
      const auto measurement = sigma_.find(seq);
      if (measurement != sigma_.end() && measurement->second != bits) ++counts_.n_strange_answers;
    }
  }

  Counts counts_;
  std::int64_t n_damaged_ = 0;
  std::unordered_map<std::int64_t, std::uint64_t> sigma_, answered_, sent_;
  std::unordered_set<std::uint64_t> commands_;
  std::unordered_set<std::int64_t> command_seqs_;
};

struct Check {
  std::string name, found, wanted;
  bool good;
};

class Checks {
 public:
  void equal(const std::string& name, std::int64_t found, std::int64_t wanted) {
    between(name, found, wanted, wanted);
  }
  void between(const std::string& name, std::int64_t found, std::int64_t least, std::int64_t most) {
    const std::string wanted = least == most
                                   ? std::to_string(least)
                                   : std::to_string(least) + " to " + std::to_string(most);
    all_.push_back({name, std::to_string(found), wanted, found >= least && found <= most});
  }
  const std::vector<Check>& all() const { return all_; }
  bool good() const {
    for (const Check& check : all_) {
      if (!check.good) return false;
    }
    return true;
  }

 private:
  std::vector<Check> all_;
};

Checks judge(const Options& options, const Counts& c) {
  Checks checks;
  const timing_t& closing = *c.closing;
  // What telemetry or logger dropped is known by the numbers of the periods; it may hide as much.
  const std::int64_t hidden = c.n_records_missing;
  checks.between("periods in the closing line", closing.n_periods, c.n_records,
                 c.n_records + hidden);
  checks.equal("periods and late ones together", closing.n_periods + closing.n_late,
               c.last_period + 1);
  checks.between("late periods", closing.n_late, c.n_late, c.n_late + hidden);
  checks.between("lost measurements", closing.n_lost, c.n_samples - c.n_answered - hidden,
                 c.n_samples - c.n_answered);
  checks.between("measurements in the log", c.n_measurements, c.n_answered, c.n_samples);
  checks.between("commands in the log", c.n_commands, c.n_sent - c.n_samples / 1000,
                 c.n_sent + hidden);
  checks.equal("commands that differ from their record", c.n_strange_commands, 0);
  checks.equal("answered sigma that differs from the plant's", c.n_strange_answers, 0);
  checks.between("records of the loop that the log lacks", hidden, 0, c.n_samples / 1000);
  checks.between("commands that the log lacks", c.n_unlogged_commands, 0, c.n_samples / 1000);
  checks.between("memory, last less first (kB)", options.memory_last_kb - options.memory_first_kb,
                 -(std::int64_t{1} << 40), options.memory_allowed_kb);
  if (options.locked) checks.equal("page faults in the loop", c.status->n_page_faults, 0);
  return checks;
}

void print_table(const Options& options, const Counts& c, const Checks& checks) {
  const auto line = [](const char* name, std::int64_t value) {
    std::printf("%-48s %14lld\n", name, static_cast<long long>(value));
  };
  line("samples of the plant", c.n_samples);
  line("periods of the controller", c.closing->n_periods);
  line("late periods, skipped whole", c.closing->n_late);
  line("lost measurements", c.closing->n_lost);
  line("duplicate measurements", c.closing->n_duplicate);
  line("faults", c.status->n_faults);
  line("times back in the loop", c.status->n_rejoins);
  line("commands dropped on their way out", c.status->n_commands_dropped);
  line("records dropped from telemetry", c.status->n_records_dropped);
  line("page faults in the loop", c.status->n_page_faults);
  std::printf("%-48s %14.1f\n", "worst wake-up (us)", 1e-3 * c.closing->worst_wake_up_ns);
  std::printf("%-48s %14.1f\n", "worst compute (us)", 1e-3 * c.closing->worst_compute_ns);
  line("memory of the controller, first (kB)", options.memory_first_kb);
  line("memory of the controller, last (kB)", options.memory_last_kb);
  std::printf("\n%-46s %16s  %s\n", "check", "found", "wanted");
  for (const Check& check : checks.all()) {
    const bool open = check.wanted.starts_with("-1099511627776 to ");
    std::printf("%-46s %16s  %s%s\n", check.name.c_str(), check.found.c_str(),
                open ? ("at most " + check.wanted.substr(18)).c_str() : check.wanted.c_str(),
                check.good ? "" : "   NOT SO");
  }
}

void print_json(const Options& options, const Counts& c, const Checks& checks) {
  const auto n = [](std::int64_t value) { return static_cast<long long>(value); };
  std::printf(
      "{\"n_samples\": %lld, \"n_periods\": %lld, \"n_late\": %lld, \"n_lost\": %lld, "
      "\"n_duplicate\": %lld, \"n_faults\": %lld, \"n_rejoins\": %lld, "
      "\"n_commands_dropped\": %lld, \"n_records_dropped\": %lld, \"n_page_faults\": %lld,\n"
      " \"n_measurements_logged\": %lld, \"n_commands_logged\": %lld, \"n_records_logged\": %lld,\n"
      " \"worst_wake_up_ns\": %lld, \"worst_compute_ns\": %lld, \"memory_first_kb\": %lld, "
      "\"memory_last_kb\": %lld, \"good\": %s}\n",
      n(c.n_samples), n(c.closing->n_periods), n(c.closing->n_late), n(c.closing->n_lost),
      n(c.closing->n_duplicate), n(c.status->n_faults), n(c.status->n_rejoins),
      n(c.status->n_commands_dropped), n(c.status->n_records_dropped), n(c.status->n_page_faults),
      n(c.n_measurements), n(c.n_commands), n(c.n_records), n(c.closing->worst_wake_up_ns),
      n(c.closing->worst_compute_ns), n(options.memory_first_kb), n(options.memory_last_kb),
      checks.good() ? "true" : "false");
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  cli::Command app("Checks the closing counters of a long wall-clock run against its log.");
  app.option("log", options.log, "LCM log").required();
  app.option("--memory-first", options.memory_first_kb, "kB, after the warm-up");
  app.option("--memory-last", options.memory_last_kb, "kB, at the end");
  app.option("--memory-allowed", options.memory_allowed_kb, "kB of growth");
  app.flag("--locked", options.locked, "memory was locked: no page fault is allowed");
  app.flag("--json", options.json, "one object instead of the table");
  if (const auto code = app.parse(argc, argv)) return *code;
  const Reader reader(options.log);
  if (!reader.counts().closing || !reader.counts().status) {
    std::fprintf(stderr, "bench_soak_check: no closing counters of the controller in the log\n");
    return 4;
  }
  const Checks checks = judge(options, reader.counts());
  if (options.json) {
    print_json(options, reader.counts(), checks);
  } else {
    print_table(options, reader.counts(), checks);
  }
  return checks.good() ? 0 : 4;
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_soak_check: %s\n", error.what());
  return 2;
}

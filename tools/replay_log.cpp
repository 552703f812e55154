#include "tools/replay_log.hpp"

#include <algorithm>
#include <string>

#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"
#include "report/log/log_events.hpp"
#include "stillframe_msgs/loop_records_t.hpp"

namespace stillframe::tools {

namespace fs = std::filesystem;
using report::LogEvent;
using stillframe_msgs::command_t;
using stillframe_msgs::loop_checkpoint_t;
using stillframe_msgs::loop_record_t;
using stillframe_msgs::loop_records_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;

namespace {

/// What one process told of itself: its sessions, told by the periods that begin anew.
struct Controller {
  std::vector<std::vector<loop_record_t>> records;
  std::vector<std::map<std::int64_t, loop_checkpoint_t>> checkpoints;

  void add(loop_record_t&& record) {
    if (records.empty() || record.period <= records.back().back().period) records.emplace_back();
    records.back().push_back(std::move(record));
  }
  void add(loop_checkpoint_t&& checkpoint) {
    if (checkpoints.empty() || checkpoint.period <= checkpoints.back().rbegin()->first) {
      checkpoints.emplace_back();
    }
    checkpoints.back().emplace(checkpoint.period, std::move(checkpoint));
  }
};

struct Run {
  std::optional<run_info_t> info;
  std::vector<measurement_t> measurements;
  std::vector<command_t> commands;
  std::string last_command;  ///< as bytes
  std::vector<std::int64_t> instances;
  std::map<std::int64_t, Controller> controllers;

  Controller& controller(std::int64_t instance) {
    if (!controllers.contains(instance)) instances.push_back(instance);
    return controllers[instance];
  }
};

class Collector {
 public:
  void take(const LogEvent& event) {
    if (event.channel == channels::run_info) {
      with<run_info_t>(event, [](Run& run, run_info_t&& info) {
        if (!run.info) run.info = std::move(info);
      });
    } else if (event.channel == channels::measurement) {
      with<measurement_t>(event, [](Run& run, measurement_t&& message) {
        const bool needed = !run.info || run.info->mode != "wall_clock";
        const bool again = !run.measurements.empty() && run.measurements.back().seq == message.seq;
        if (needed && !again) run.measurements.push_back(std::move(message));
      });
    } else if (event.channel == channels::command) {
      with<command_t>(event, [&event](Run& run, command_t&& message) {
        if (run.last_command == event.payload) return;
        run.last_command = event.payload;
        run.commands.push_back(std::move(message));
      });
    } else if (event.channel == channels::loop) {
      with<loop_records_t>(event, [](Run& run, loop_records_t&& message) {
        Controller& controller = run.controller(message.instance);
        for (loop_record_t& record : message.records) controller.add(std::move(record));
      });
    } else if (event.channel == channels::checkpoint) {
      with<loop_checkpoint_t>(event, [](Run& run, loop_checkpoint_t&& message) {
        Controller& controller = run.controller(message.instance);
        controller.add(std::move(message));
      });
    }
  }

  std::map<std::int64_t, Run> runs;
  std::int64_t n_undecodable = 0;

 private:
  template <class Message, class Store>
  void with(const LogEvent& event, Store&& store) {
    Message message;
    if (!decode(event.payload, message)) {
      ++n_undecodable;
      return;
    }
    Run& run = runs[message.run_id];
    store(run, std::move(message));
  }
};

Run choose(std::map<std::int64_t, Run>& runs, const std::string& place,
           std::optional<std::int64_t> run_id) {
  std::erase_if(runs, [](const auto& entry) { return !entry.second.info; });
  std::string known;
  for (const auto& [id, run] : runs) known += (known.empty() ? "" : ", ") + std::to_string(id);
  if (runs.empty()) {
    throw InputError(place + ": no " + channels::run_info + " message of a run in this log");
  }
  if (!run_id && runs.size() > 1) {
    throw InputError(place + ": several runs in one log, name one by --run-id: " + known);
  }
  const auto found = run_id ? runs.find(*run_id) : runs.begin();
  if (found == runs.end()) {
    throw InputError(place + ": run_id: found none with " + std::to_string(*run_id) +
                     ", this log holds " + known);
  }
  return std::move(found->second);
}

[[noreturn]] void refuse_size(const std::string& place, const std::string& what, std::int64_t found,
                              std::int64_t wanted) {
  throw InputError(place + ": " + what + ": found " + std::to_string(found) + " legs, " +
                   channels::run_info + " says " + std::to_string(wanted));
}

void check_sizes(const ReplayLog& log, const std::string& place) {
  const std::int32_t m = log.info.n_legs;
  for (const auto& message : log.measurements) {
    if (message.n_legs != m) refuse_size(place, channels::measurement, message.n_legs, m);
  }
  for (const auto& message : log.commands) {
    if (message.n_legs != m) refuse_size(place, channels::command, message.n_legs, m);
  }
  for (const auto& session : log.sessions) {
    for (const auto& record : session.records) {
      if (record.n_legs != m) refuse_size(place, channels::loop, record.n_legs, m);
    }
  }
}

void check_contents(const ReplayLog& log, const std::string& place) {
  if (log.info.mode == "lock_step" || log.info.mode == "single_process") {
    if (log.measurements.empty()) {
      throw InputError(place + ": no " + channels::measurement + " message in this log");
    }
    if (log.commands.empty()) {
      throw InputError(place + ": no " + channels::command + " message in this log");
    }
  } else if (log.info.mode != "wall_clock") {
    throw InputError(place + ": mode: found '" + log.info.mode +
                     "', allowed are lock_step, single_process and wall_clock");
  } else if (log.sessions.empty()) {
    throw InputError(place + ": no " + channels::loop +
                     " message in this log; a wall-clock run cannot be replayed without the "
                     "controller's own records of what it saw, and when");
  }
}

}  // namespace

ReplayLog read_replay_log(const fs::path& path, std::optional<std::int64_t> run_id) {
  const std::string place = path.string();
  Collector collector;
  const report::LogDamage damage =
      report::for_each_event(path, [&collector](const LogEvent& event) { collector.take(event); });
  Run run = choose(collector.runs, place, run_id);
  ReplayLog log;
  log.info = std::move(*run.info);
  log.measurements = std::move(run.measurements);
  log.commands = std::move(run.commands);
  log.n_damaged = damage.n_damaged + collector.n_undecodable;
  for (const std::int64_t instance : run.instances) {
    Controller& controller = run.controllers.at(instance);
    for (std::size_t i = 0; i < controller.records.size(); ++i) {
      log.sessions.push_back({.records = std::move(controller.records[i]), .checkpoints = {}});
      if (i < controller.checkpoints.size()) {
        log.sessions.back().checkpoints = std::move(controller.checkpoints[i]);
      }
    }
  }
  check_contents(log, place);
  check_sizes(log, place);
  return log;
}

}  // namespace stillframe::tools

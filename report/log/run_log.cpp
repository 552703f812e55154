#include "report/log/run_log.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "core/yaml/input_error.hpp"
#include "msgs/channels.hpp"
#include "report/log/log_events.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::report {

using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;
using stillframe_msgs::timing_t;

namespace {

/// The messages of one channel of one run, in the order of the file.
template <typename Message>
struct Stream {
  std::vector<Message> messages;
  std::int64_t first_us = 0, last_us = 0;

  void add(const LogEvent& event, Message&& message) {
    if (messages.empty()) first_us = event.timestamp_us;
    last_us = event.timestamp_us;
    messages.push_back(std::move(message));
  }
};

/// All that one run left in the log.
struct Run {
  std::optional<run_info_t> info;
  Stream<measurement_t> measurements;
  Stream<command_t> commands;
  std::vector<timing_t> timings;
};

struct Contents {
  std::map<std::int64_t, Run> runs;
  std::int64_t n_undecodable = 0;
  LogDamage damage;
};

Contents read_contents(const std::filesystem::path& path) {
  Contents contents;
  const auto decode_into = [&contents](const LogEvent& event, auto message, auto&& store) {
    if (decode(event.payload, message)) {
      store(contents.runs[message.run_id], std::move(message));
    } else {
      ++contents.n_undecodable;
    }
  };
  contents.damage = for_each_event(path, [&](const LogEvent& event) {
    if (event.channel == channels::measurement) {
      decode_into(event, measurement_t{}, [&](Run& run, measurement_t&& message) {
        run.measurements.add(event, std::move(message));
      });
    } else if (event.channel == channels::command) {
      decode_into(event, command_t{}, [&](Run& run, command_t&& message) {
        run.commands.add(event, std::move(message));
      });
    } else if (event.channel == channels::run_info) {
      decode_into(event, run_info_t{}, [](Run& run, run_info_t&& message) {
        if (!run.info) run.info = std::move(message);
      });
    } else if (event.channel == channels::timing) {
      decode_into(event, timing_t{},
                  [](Run& run, timing_t&& message) { run.timings.push_back(std::move(message)); });
    }
  });
  return contents;
}

std::string list_of_runs(const std::map<std::int64_t, Run>& runs) {
  std::string list;
  for (const auto& [id, run] : runs) {
    if (run.info) list += (list.empty() ? "" : ", ") + std::to_string(id);
  }
  return list;
}

Run choose_run(Contents& contents, const std::string& place, std::optional<std::int64_t> run_id) {
  auto& runs = contents.runs;
  const std::string known = list_of_runs(runs);
  if (known.empty()) {
    throw InputError(place + (runs.empty() ? ": no message of a stillframe run in this log"
                                           : ": no " + std::string(channels::run_info) +
                                                 " message, so the others cannot be read"));
  }
  if (run_id) {
    const auto found = runs.find(*run_id);
    if (found == runs.end() || !found->second.info) {
      throw InputError(place + ": run_id: found none with " + std::to_string(*run_id) +
                       ", this log holds " + known);
    }
    return std::move(found->second);
  }
  if (known.find(',') != std::string::npos) {
    throw InputError(place + ": several runs in one log, name the run_id: " + known);
  }
  return std::move(std::find_if(runs.begin(), runs.end(), [](const auto& r) {
                     return r.second.info.has_value();
                   })->second);
}

void check_info(const run_info_t& info, const std::string& place) {
  if (info.format_version != 1) {
    throw InputError(place + ": format_version: found " + std::to_string(info.format_version) +
                     ", this program reads 1");
  }
  if (!(info.sample_rate_hz > 0)) {
    throw InputError(place + ": sample_rate_hz: found " + std::to_string(info.sample_rate_hz) +
                     ", allowed are positive numbers");
  }
}

template <typename Message>
bool same_bytes(const Message& a, const Message& b) {
  const int size = a.getEncodedSize();
  if (b.getEncodedSize() != size) return false;
  std::vector<char> bytes_a(size), bytes_b(size);
  a.encode(bytes_a.data(), 0, size);
  b.encode(bytes_b.data(), 0, size);
  return bytes_a == bytes_b;
}

/// Sorts by seq, drops identical repeats, and counts both.
template <typename Message>
ChannelCount order_by_seq(std::vector<Message>& messages, const std::string& place,
                          const std::string& channel) {
  ChannelCount count;
  std::int64_t largest = messages.empty() ? 0 : messages.front().seq;
  for (const Message& message : messages) {
    // A repeat of the newest message is no disorder, so only what a stable sort moves is counted.
    if (message.seq < largest) ++count.n_out_of_order;
    largest = std::max(largest, message.seq);
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const Message& a, const Message& b) { return a.seq < b.seq; });
  std::vector<Message> distinct;
  distinct.reserve(messages.size());
  for (Message& message : messages) {
    if (distinct.empty() || distinct.back().seq != message.seq) {
      distinct.push_back(std::move(message));
    } else if (same_bytes(distinct.back(), message)) {
      ++count.n_duplicates;
    } else {
      throw InputError(place + ": " + channel + ": two different messages with seq " +
                       std::to_string(message.seq) + ", they cannot be of one run");
    }
  }
  messages = std::move(distinct);
  count.n_received = static_cast<std::int64_t>(messages.size());
  return count;
}

template <typename Message>
std::vector<std::int64_t> seq_of(const std::vector<Message>& messages) {
  std::vector<std::int64_t> seq(messages.size());
  std::transform(messages.begin(), messages.end(), seq.begin(),
                 [](const Message& m) { return m.seq; });
  return seq;
}

/// Gaps in the increasing `seq` within first .. end - 1.
void find_gaps(const std::vector<std::int64_t>& seq, std::int64_t first, std::int64_t end,
               ChannelCount& count) {
  const auto add = [&count](std::int64_t from, std::int64_t to) {
    if (from > to) return;
    count.gaps.push_back({from, to});
    count.n_lost += to - from + 1;
  };
  std::int64_t expected = first;
  for (const std::int64_t s : seq) {
    add(expected, s - 1);
    expected = s + 1;
  }
  add(expected, end - 1);
}

template <typename Message>
Eigen::MatrixXd table(const std::vector<Message>& messages, std::vector<double> Message::*field,
                      std::int32_t n_columns, const std::string& what) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(messages.size()), n_columns);
  for (std::size_t k = 0; k < messages.size(); ++k) {
    const std::vector<double>& row = messages[k].*field;
    if (row.size() != static_cast<std::size_t>(n_columns)) {
      throw InputError(what + ": found " + std::to_string(row.size()) + " values at seq " +
                       std::to_string(messages[k].seq) + ", run_info says " +
                       std::to_string(n_columns));
    }
    values.row(static_cast<Eigen::Index>(k)) =
        Eigen::Map<const Eigen::RowVectorXd>(row.data(), n_columns);
  }
  return values;
}

void fill_measurements(RunLog& log, std::vector<measurement_t>& messages,
                       const std::string& place) {
  log.measurements = order_by_seq(messages, place, channels::measurement);
  log.seq = seq_of(messages);
  find_gaps(log.seq, 0, std::max(log.info.n_samples, log.seq.back() + 1), log.measurements);
  log.time_s.resize(static_cast<Eigen::Index>(messages.size()));
  for (std::size_t k = 0; k < messages.size(); ++k) {
    log.time_s(static_cast<Eigen::Index>(k)) = 1e-9 * static_cast<double>(messages[k].time_ns);
  }
  const run_info_t& info = log.info;
  log.floor_acceleration = table(messages, &measurement_t::floor_acceleration, info.n_floor,
                                 place + ": floor_acceleration");
  log.sigma = table(messages, &measurement_t::sigma, info.n_legs, place + ": sigma");
  log.applied_force =
      table(messages, &measurement_t::applied_force, info.n_legs, place + ": applied_force");
  log.frame_acceleration = table(messages, &measurement_t::frame_acceleration, info.n_frame,
                                 place + ": frame_acceleration");
}

void fill_commands(RunLog& log, std::vector<command_t>& messages, const std::string& place) {
  log.commands = order_by_seq(messages, place, channels::command);
  log.command_seq = seq_of(messages);
  if (!messages.empty()) {
    find_gaps(log.command_seq, log.command_seq.front(), log.command_seq.back() + 1, log.commands);
  }
  log.command_force = table(messages, &command_t::force, log.info.n_legs, place + ": force");
  log.n_saturated = std::count_if(messages.begin(), messages.end(),
                                  [](const command_t& command) { return command.saturated != 0; });
}

}  // namespace

RunLog read_run_log(const std::filesystem::path& path, std::optional<std::int64_t> run_id) {
  const std::string place = path.string();
  Contents contents = read_contents(path);
  Run run = choose_run(contents, place, run_id);
  check_info(*run.info, place);
  if (run.measurements.messages.empty()) {
    throw InputError(place + ": run " + std::to_string(run.info->run_id) + " has a " +
                     channels::run_info + " but no " + channels::measurement + " message");
  }
  RunLog log;
  log.info = std::move(*run.info);
  log.n_damaged = contents.damage.n_damaged + contents.n_undecodable;
  log.unread_bytes = contents.damage.unread_bytes;
  log.log_duration_s =
      1e-6 * static_cast<double>(run.measurements.last_us - run.measurements.first_us);
  fill_measurements(log, run.measurements.messages, place);
  fill_commands(log, run.commands.messages, place);
  for (const timing_t& timing : run.timings) {
    if (timing.source == "plant") log.plant_timing = timing;
    if (timing.source == "controller") log.controller_timing = timing;
  }
  return log;
}

}  // namespace stillframe::report

#include "tools/replay_law.hpp"

#include <algorithm>
#include <bit>
#include <span>

#include "controller/answer.hpp"
#include "controller/law.hpp"
#include "controller/supervisor.hpp"
#include "controller/telemetry.hpp"
#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"

namespace stillframe::tools {

using controller::Answer;
using controller::Gains;
using controller::law_from_gains;
using controller::LoopRecord;
using controller::Supervisor;
using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;

namespace {

using Found = std::optional<ReplayDifference>;

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// A command that was computed here.
struct Computed {
  std::int64_t seq = 0, time_ns = 0, period = 0;
  bool saturated = false;
  std::vector<double> force;
};

std::string leg_name(const ReplayLog& log, std::size_t i) {
  return i < log.info.leg_names.size() ? log.info.leg_names[i] : "leg " + std::to_string(i + 1);
}

Found compare_number(const char* field, double recorded, double computed) {
  if (same_bits(recorded, computed)) return std::nullopt;
  ReplayDifference difference;
  difference.field = field;
  difference.recorded = recorded;
  difference.computed = computed;
  return difference;
}

Found compare_force(const ReplayLog& log, std::span<const double> recorded,
                    std::span<const double> computed) {
  for (std::size_t i = 0; i < computed.size(); ++i) {
    if (Found found = compare_number("force", recorded[i], computed[i])) {
      found->leg = leg_name(log, i);
      return found;
    }
  }
  return std::nullopt;
}

Found compare(const ReplayLog& log, const command_t& recorded, const Computed& computed) {
  Found found = compare_force(log, recorded.force, computed.force);
  if (!found) {
    found = compare_number("saturated", recorded.saturated != 0 ? 1 : 0, computed.saturated);
  }
  if (!found) {
    found = compare_number("time_ns", static_cast<double>(recorded.time_ns),
                           static_cast<double>(computed.time_ns));
  }
  if (!found) return std::nullopt;
  found->channel = channels::command;
  found->seq = computed.seq;
  found->period = computed.period;
  return found;
}

/// Keeps the difference of the earliest period, or of the earliest command where there are none.
void keep_first(ReplayResult& result, ReplayDifference found) {
  const auto when = [](const ReplayDifference& d) { return std::pair(d.period, d.seq); };
  if (!result.first || when(found) < when(*result.first)) result.first = std::move(found);
}

/// Commands of one seq, computed and logged: equal ones are paired first, because a seq can stand
/// for two commands where the loop went on without measurements.
void match_group(const ReplayLog& log, std::span<const Computed> computed,
                 std::vector<const command_t*> logged, ReplayResult& result) {
  std::vector<const Computed*> left;
  for (const Computed& command : computed) {
    const auto same = std::find_if(logged.begin(), logged.end(), [&](const command_t* other) {
      return !compare(log, *other, command);
    });
    if (same == logged.end()) {
      left.push_back(&command);
    } else {
      logged.erase(same);
    }
  }
  const std::size_t n_pairs = std::min(left.size(), logged.size());
  for (std::size_t i = 0; i < n_pairs; ++i) {
    ++result.n_different;
    keep_first(result, *compare(log, *logged[i], *left[i]));
  }
  result.n_not_logged += static_cast<std::int64_t>(left.size() - n_pairs);
  result.n_other += static_cast<std::int64_t>(logged.size() - n_pairs);
}

void match_commands(const ReplayLog& log, std::vector<Computed>& computed, ReplayResult& result) {
  const auto by_seq = [](const Computed& a, const Computed& b) { return a.seq < b.seq; };
  std::stable_sort(computed.begin(), computed.end(), by_seq);
  std::map<std::int64_t, std::vector<const command_t*>> logged;
  for (const command_t& command : log.commands) logged[command.seq].push_back(&command);
  for (auto begin = computed.begin(); begin != computed.end();) {
    const auto end = std::upper_bound(begin, computed.end(), *begin, by_seq);
    const auto found = logged.find(begin->seq);
    const bool any = found != logged.end();
    match_group(log, {begin, end}, any ? found->second : std::vector<const command_t*>{}, result);
    if (any) logged.erase(found);
    begin = end;
  }
  for (const auto& [seq, commands] : logged) {
    result.n_other += static_cast<std::int64_t>(commands.size());
  }
}

void check_legs(const ReplayLog& log, const Gains& gains) {
  if (gains.n_legs() == log.info.n_legs) return;
  throw InputError("the gains are for " + std::to_string(gains.n_legs()) + " legs, the log has " +
                   std::to_string(log.info.n_legs));
}

/// Goes through the records of one loop.
class SessionReplay {
 public:
  SessionReplay(const ReplayLog& log, const LoopSession& session, Supervisor supervisor,
                ReplayResult& result)
      : log_(log),
        session_(session),
        supervisor_(std::move(supervisor)),
        memory_(supervisor_.memory_size()),
        result_(result) {
    command_.force = Eigen::VectorXd::Zero(supervisor_.n_legs());
  }

  void run(std::vector<Computed>& computed) {
    for (const auto& message : session_.records) {
      if (going_ && message.period - message.n_elapsed != last_period_) {
        ++result_.n_gaps;
        going_ = false;
      }
      take_up(message.period);
      last_period_ = message.period;
      if (going_) {
        step(controller::from_message(message), computed);
      } else {
        ++result_.n_not_computed;
      }
    }
  }

 private:
  /// At a checkpoint: compares the memory on the way, and goes on from the recorded one in any
  /// case, so that one difference does not spoil all that follows.
  void take_up(std::int64_t period) {
    const auto found = session_.checkpoints.find(period);
    if (found == session_.checkpoints.end()) return;
    const std::vector<double>& recorded = found->second.memory;
    if (recorded.size() != memory_.size()) {
      throw InputError("the checkpoint before period " + std::to_string(period) + " has " +
                       std::to_string(recorded.size()) + " values, a controller of these gains " +
                       std::to_string(memory_.size()));
    }
    if (going_) {
      supervisor_.save(memory_);
      for (std::size_t i = 0; i < memory_.size(); ++i) {
        Found difference = compare_number("memory", recorded[i], memory_[i]);
        if (!difference) continue;
        difference->leg = "value " + std::to_string(i);
        report(channels::checkpoint, period, std::move(*difference));
        break;
      }
    }
    supervisor_.restore(recorded);
    going_ = true;
  }

  void step(const LoopRecord& record, std::vector<Computed>& computed) {
    const bool have = record.defect == controller::Defect::none;
    const bool sent = supervisor_.step({.n_elapsed = record.n_elapsed,
                                        .measurement = have ? &record.measurement : nullptr,
                                        .defect = record.defect,
                                        .request = record.request},
                                       command_);
    ++result_.n_periods;
    result_.n_commands += sent ? 1 : 0;
    if (Found found = compare(record, sent)) {
      ++result_.n_different;
      report(channels::loop, record.period, std::move(*found));
    }
    if (!sent) return;
    computed.push_back({.seq = command_.seq,
                        .time_ns = command_.time_ns,
                        .period = record.period,
                        .saturated = command_.saturated,
                        .force = {command_.force.begin(), command_.force.end()}});
  }

  Found compare(const LoopRecord& record, bool sent) const {
    const auto span_of = [](const Eigen::VectorXd& values) {
      return std::span<const double>(values.data(), static_cast<std::size_t>(values.size()));
    };
    if (Found found = compare_force(log_, span_of(record.command.force), span_of(command_.force))) {
      return found;
    }
    if (Found found = compare_number("sent", record.sent, sent)) return found;
    if (Found found = compare_number("saturated", record.command.saturated, command_.saturated)) {
      return found;
    }
    const auto number = [](auto value) { return static_cast<double>(value); };
    if (Found found = compare_number("state", number(record.state), number(supervisor_.state()))) {
      return found;
    }
    return compare_number("fault", number(record.fault), number(supervisor_.fault()));
  }

  void report(const char* channel, std::int64_t period, ReplayDifference difference) {
    difference.channel = channel;
    difference.seq = command_.seq;
    difference.period = period;
    keep_first(result_, std::move(difference));
  }

  const ReplayLog& log_;
  const LoopSession& session_;
  Supervisor supervisor_;
  std::vector<double> memory_;
  ReplayResult& result_;
  controller::Command command_;
  bool going_ = false;
  std::int64_t last_period_ = -1;
};

}  // namespace

ReplayResult replay_lock_step(const ReplayLog& log, const Gains& gains) {
  check_legs(log, gains);
  Answer answer(law_from_gains(gains), gains.force_limit_n, log.info.loop != "passive");
  command_t command;
  answer.prepare(command);
  std::vector<Computed> computed;
  std::int64_t last_seq = -1;
  for (const measurement_t& measurement : log.measurements) {
    if (measurement.seq <= last_seq) continue;
    if (measurement.seq != last_seq + 1) {
      throw InputError("measurement " + std::to_string(last_seq + 1) +
                       " is not in the log; what the law did with it cannot be computed again");
    }
    last_seq = measurement.seq;
    answer.answer(measurement, command);
    computed.push_back({.seq = command.seq,
                        .time_ns = command.time_ns,
                        .saturated = command.saturated != 0,
                        .force = command.force});
  }
  ReplayResult result;
  match_commands(log, computed, result);
  result.n_commands = static_cast<std::int64_t>(computed.size()) - result.n_not_logged;
  return result;
}

ReplayResult replay_wall_clock(const ReplayLog& log, const Gains& gains,
                               const controller::Policy& policy) {
  check_legs(log, gains);
  const Supervisor supervisor(gains, policy, log.info.loop != "passive");
  ReplayResult result;
  std::vector<Computed> computed;
  for (const LoopSession& session : log.sessions) {
    SessionReplay(log, session, supervisor, result).run(computed);
  }
  if (!log.commands.empty()) {
    match_commands(log, computed, result);
  } else {
    result.n_not_logged = static_cast<std::int64_t>(computed.size());
  }
  return result;
}

}  // namespace stillframe::tools

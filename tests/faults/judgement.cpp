#include "tests/faults/judgement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "controller/policy.hpp"
#include "core/numerics/worst.hpp"
#include "tests/faults/passive_frame.hpp"

namespace stillframe::faults {

using stillframe_msgs::controller_status_t;

namespace {

/// The statuses from the one before the fault to the one that ended it.
std::vector<StatusAt> during(const Trace& trace, const Marks& marks) {
  const auto from = trace.statuses.begin();
  return {from + static_cast<std::ptrdiff_t>(marks.before.n_statuses) - 1,
          from + static_cast<std::ptrdiff_t>(marks.end.n_statuses)};
}

std::string text_of(std::int32_t fault) {
  return std::string(to_text(static_cast<controller::Fault>(fault)));
}

std::string outcome(const std::vector<StatusAt>& statuses, const Marks& marks) {
  const controller_status_t& first = statuses.front().status;
  bool left = false;
  const controller_status_t *faulty = nullptr, *stuck = nullptr;
  std::int64_t n_faults = first.n_faults;
  for (const StatusAt& at : statuses) {
    left |= at.status.state != controller_status_t::ACTIVE;
    if (at.status.latched && stuck == nullptr) stuck = &at.status;
    if (at.status.instance != first.instance) return "joined";
    if (at.status.n_faults > n_faults) faulty = &at.status;
    n_faults = at.status.n_faults;
  }
  if (stuck != nullptr) return text_of(stuck->fault) + ", latched";
  if (faulty != nullptr) return text_of(faulty->fault);
  if (marks.before.run != marks.end.run) return "joined";
  return left ? "resumed" : "active";
}

std::int64_t recovery(const std::vector<StatusAt>& statuses, const Marks& marks) {
  const StatusAt* active_again = nullptr;
  bool active = true;
  for (const StatusAt& at : statuses) {
    const bool now = at.status.state == controller_status_t::ACTIVE;
    if (now && !active) active_again = &at;
    active = now;
  }
  if (active_again == nullptr) return 0;
  const bool other_run = active_again->run + 1 != marks.after.run;
  const std::int64_t from = marks.reset ? marks.reset->sample : other_run ? 0 : marks.after.sample;
  return std::max<std::int64_t>(0, active_again->sample - from);
}

/// The peaks of an episode. It may reach from one plant process into the next.
struct Peaks {
  Accelerations active{}, passive{}, left{};  ///< left: to itself, with the force that it had
  double model_error = 0;                     ///< of the frame that left is computed with
};

void raise(Accelerations& largest, const Accelerations& peak) {
  for (std::size_t i = 0; i < largest.size(); ++i) largest[i] = worst_of(largest[i], peak[i]);
}

/// Largest difference in samples [0, end) over the peak there.
double difference(const std::vector<Accelerations>& a, const std::vector<Accelerations>& b,
                  std::int64_t end) {
  std::vector<Accelerations> error(a.begin(), a.begin() + end);
  for (std::size_t k = 0; k < error.size(); ++k) {
    for (std::size_t i = 0; i < error[k].size(); ++i) error[k][i] -= b[k][i];
  }
  return largest_ratio(peak(error, 0, end), peak(a, 0, end));
}

Peaks peaks(Workbench& bench, const Trace& trace, const Marks& marks) {
  Peaks result;
  for (std::size_t run = marks.before.run - 1; run < marks.end.run; ++run) {
    const RunTrace& seen = trace.runs[run];
    const bool first = run + 1 == marks.before.run, last = run + 1 == marks.end.run;
    const std::int64_t begin = first ? marks.before.sample : 0;
    const auto end = last ? marks.end.sample : static_cast<std::int64_t>(seen.frame.size());
    const auto left = bench.held_from(seen.applied, begin, end);
    raise(result.active, peak(seen.frame, begin, end));
    raise(result.passive, peak(bench.passive(end), begin, end));
    raise(result.left, peak(left, begin, end));
    if (first) result.model_error = difference(left, seen.frame, begin);
  }
  return result;
}

void compare(Workbench& bench, const Trace& trace, const Marks& marks, Episode& episode) {
  const Peaks found = peaks(bench, trace, marks);
  const Accelerations minute =
      peak(bench.passive(Workbench::n_reference), 0, Workbench::n_reference);
  Accelerations either = minute;
  raise(either, found.left);
  episode.over_passive = largest_ratio(found.active, either);
  episode.over_minute = largest_ratio(found.active, minute);
  episode.over_same = largest_ratio(found.active, found.passive);
  episode.over_left = largest_ratio(found.active, found.left);
  episode.model_error = found.model_error;
}

/// By how many periods the latest sample from mark to mark came later than the most punctual one.
double lateness(const RunTrace& run, std::int64_t begin, std::int64_t end, double rate_hz) {
  double earliest = HUGE_VAL, latest = -HUGE_VAL;
  for (std::size_t k = 0; k < run.arrival_ns.size(); ++k) {
    if (run.arrival_ns[k] == 0) continue;
    const double offset =
        static_cast<double>(run.arrival_ns[k]) * 1e-9 * rate_hz - static_cast<double>(k);
    earliest = std::min(earliest, offset);
    const auto sample = static_cast<std::int64_t>(k);
    if (sample >= begin && sample <= end) latest = std::max(latest, offset);
  }
  return latest - earliest;
}

/// What the machine did meanwhile, in periods.
struct Machine {
  double bystander = 0;  ///< latest wake-up of a thread that only wakes up
  double samples = 0;    ///< latest sample at the relay
  double wake_up = 0;    ///< latest wake-up of the loop, or all that it skipped
  double n_late = 0;     ///< measurements that came too late without the relay's doing
  double transit = 0;    ///< longest way of a measurement from the relay to the controller

  double worst() const { return std::max({bystander, samples, wake_up, n_late, transit}); }
};

constexpr auto late = static_cast<std::int64_t>(controller::Defect::late);

Machine machine(Workbench& bench, const Trace& trace, const std::vector<StatusAt>& statuses,
                const Kind& kind, const Marks& marks) {
  const double rate_hz = bench.rate_hz();
  const auto periods = [&](std::int64_t ns) { return static_cast<double>(ns) * 1e-9 * rate_hz; };
  Machine found;
  found.bystander = bench.bystander().worst_s(marks.before.time_ns, marks.end.time_ns) * rate_hz;
  found.samples =
      lateness(trace.runs[marks.before.run - 1], marks.before.sample, marks.end.sample, rate_hz);
  // Records may be dropped, this is always counted.
  found.wake_up =
      static_cast<double>(statuses.back().status.n_late - statuses.front().status.n_late);
  for (std::size_t i = marks.before.n_periods; i < marks.end.n_periods; ++i) {
    found.wake_up = std::max(found.wake_up, periods(trace.periods[i].wake_up_ns));
    // Where the relay holds messages back, that is the fault.
    if (kind.delays) continue;
    found.n_late += trace.periods[i].defect == late ? 1 : 0;
    found.transit = std::max(found.transit, periods(trace.periods[i].transit_ns));
  }
  return found;
}

std::string in_words(const Machine& machine, const Trace& trace, const Marks& marks) {
  std::array<int, 5> defects{};
  for (std::size_t i = marks.before.n_periods; i < marks.end.n_periods; ++i) {
    ++defects.at(static_cast<std::size_t>(trace.periods[i].defect));
  }
  char text[320];
  std::snprintf(text, sizeof text,
                "late by periods: bystander %.1f, samples %.1f, loop %.1f, way to it %.1f; of its "
                "periods %d had a measurement, %d none, %d a late one, %d not finite, %d out of "
                "range",
                machine.bystander, machine.samples, machine.wake_up, machine.transit, defects[0],
                defects[1], defects[2], defects[3], defects[4]);
  return text;
}

void count(const std::vector<StatusAt>& statuses, const Kind& kind, const Marks& marks,
           Episode& episode) {
  const controller_status_t &first = statuses.front().status, &last = statuses.back().status;
  const RelayCounts &before = marks.before.counts, &after = marks.end.counts;
  const std::int64_t n_corrupted = after.n_corrupted - before.n_corrupted;
  switch (kind.counted) {
    case Counted::nothing:
      return;
    case Counted::measurements_lost:
      episode.n_inflicted = after.measurements.n_lost - before.measurements.n_lost;
      episode.n_counted = last.n_lost - first.n_lost;
      // For each that is lost there is a period without one, or a period that was skipped.
      episode.n_at_most = last.n_missing - first.n_missing + last.n_late - first.n_late;
      return;
    case Counted::messages_bad:
      episode.n_inflicted = n_corrupted;
      episode.n_counted = last.n_bad_messages - first.n_bad_messages;
      break;
    case Counted::duplicates:
      episode.n_inflicted = n_corrupted + after.measurements.n_duplicated -
                            before.measurements.n_duplicated + after.measurements.n_reordered -
                            before.measurements.n_reordered;
      episode.n_counted = last.n_duplicate - first.n_duplicate;
      break;
  }
  episode.n_at_most = episode.n_inflicted;
}

}  // namespace

Episode judge(Workbench& bench, const Trace& trace, const Kind& kind, const Marks& marks) {
  const std::vector<StatusAt> statuses = during(trace, marks);
  Episode episode;
  episode.seed = marks.seed;
  episode.outcome = outcome(statuses, marks);
  episode.recovery = recovery(statuses, marks);
  // With what a fault does itself still less than is held.
  constexpr double few = 3;
  const Machine found = machine(bench, trace, statuses, kind, marks);
  episode.lateness = in_words(found, trace, marks);
  // Where samples and loop are late because that is the fault, the bystander alone is a witness.
  const bool began_active = statuses.front().status.state == controller_status_t::ACTIVE;
  episode.disturbed = !began_active || (kind.stops_time ? found.bystander : found.worst()) > few;
  compare(bench, trace, marks, episode);
  count(statuses, kind, marks, episode);
  return episode;
}

}  // namespace stillframe::faults

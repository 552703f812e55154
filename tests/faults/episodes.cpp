#include "tests/faults/episodes.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>

#include "controller/policy.hpp"
#include "msgs/clock.hpp"
#include "tests/faults/judgement.hpp"
#include "tests/faults/samples.hpp"

namespace stillframe::faults {

using stillframe_msgs::control_request_t;
using stillframe_msgs::controller_status_t;

namespace {

constexpr std::int64_t settle_samples = 150;  // beyond the longest gap that a fade is resumed after
constexpr std::int64_t rest_samples = 200;

Mark mark(Rig& rig) {
  const RelayCounts counts = rig.relay().counts();
  return rig.relay().look([&](const Trace& trace) {
    return Mark{.run = trace.runs.size(),
                .sample = trace.sample(),
                .time_ns = monotonic_ns(),
                .n_statuses = trace.statuses.size(),
                .n_periods = trace.periods.size(),
                .counts = counts};
  });
}

bool is_settled(const controller_status_t& status) {
  return status.state == controller_status_t::ACTIVE || status.latched;
}

/// Waits until a status that is younger than the fault says active, or latched.
void wait_until_settled(Rig& rig, const Kind& kind, const Mark& before, const Mark& after) {
  const std::int64_t old = rig.relay().look(
      [&](const Trace& trace) { return trace.statuses.at(before.n_statuses - 1).status.instance; });
  const std::size_t runs = before.run + (kind.plant_restarts ? 1 : 0);
  const std::int64_t sample = (kind.plant_restarts ? 0 : after.sample) + settle_samples;
  rig.wait("the end of the fault", [&](const Trace& trace) {
    if (trace.runs.size() < runs || trace.statuses.empty()) return false;
    const StatusAt& at = trace.statuses.back();
    if (kind.controller_restarts && at.status.instance == old) return false;
    return at.run + 1 == trace.runs.size() && at.sample >= sample && is_settled(at.status);
  });
}

void wait_until_active(Rig& rig) {
  rig.wait("the controller to be active", [](const Trace& trace) {
    return trace.status() != nullptr && trace.status()->state == controller_status_t::ACTIVE;
  });
}

bool is_latched(Rig& rig) {
  return rig.relay().look([](const Trace& trace) { return trace.status()->latched; });
}

Marks play(Rig& rig, const Kind& kind, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Stage stage{.rig = rig, .random = random, .seed = seed};
  rig.wait_samples(stage.whole_between(50, 250));
  wait_until_active(rig);  // the machine may have made it let go since the last episode
  Marks marks;
  marks.seed = seed;
  marks.before = mark(rig);
  kind.inflict(stage);
  marks.after = mark(rig);
  wait_until_settled(rig, kind, marks.before, marks.after);
  if (is_latched(rig)) {
    rig.wait_samples(rest_samples);
    marks.reset = mark(rig);
    rig.ask(control_request_t::RESET);
    rig.wait("the reset", [](const Trace& seen) { return !seen.status()->latched; });
    rig.ask(control_request_t::START);
    wait_until_active(rig);
  }
  marks.recovered = mark(rig);
  rig.wait_samples(rest_samples);
  marks.end = mark(rig);
  return marks;
}

}  // namespace

KindResult run_kind(Workbench& bench, const Kind& kind, int number, const TableOptions& options) {
  KindResult result{.name = kind.name,
                    .allowed = kind.allowed,
                    .at_most = kind.at_most,
                    .episodes = {},
                    .exit_code = {},
                    .trouble = {},
                    .by_machine = false};
  std::vector<Marks> all;
  Rig rig(
      bench,
      {.number = number, .controller_prefix = kind.controller_prefix, .policy = options.policy});
  try {
    rig.start_controller();
    rig.start_plant();
    wait_until_active(rig);
    for (const std::uint64_t seed : options.seeds) all.push_back(play(rig, kind, seed));
    result.exit_code = rig.end();
  } catch (const MachineTrouble& error) {
    result.trouble = error.what();
    result.by_machine = true;
  } catch (const std::exception& error) {
    result.trouble = error.what();
  }
  const Trace trace = rig.relay().look([](const Trace& seen) { return seen; });
  if (!options.samples.empty()) write_samples(options.samples, kind.name, trace, bench);
  for (const Marks& marks : all) result.episodes.push_back(judge(bench, trace, kind, marks));
  return result;
}

std::vector<KindResult> run_kinds(Workbench& bench, const std::vector<Kind>& kinds,
                                  const TableOptions& options) {
  constexpr int side_by_side = 3;
  std::vector<KindResult> results(kinds.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&](int number) {
    for (std::size_t i = next++; i < kinds.size(); i = next++) {
      if (!kinds[i].alone) results[i] = run_kind(bench, kinds[i], number, options);
    }
  };
  std::vector<std::thread> threads;
  for (int number = 0; number < side_by_side; ++number) threads.emplace_back(work, number);
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    // A machine that is too busy for three may not be too busy for one.
    if (kinds[i].alone || !results[i].trouble.empty()) {
      results[i] = run_kind(bench, kinds[i], 0, options);
    }
  }
  return results;
}

}  // namespace stillframe::faults

#include <iostream>
#include <memory>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/replay_law.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ReplayOptions {
  std::filesystem::path log;
  std::optional<std::filesystem::path> gains, policy;
  std::optional<std::int64_t> run_id;
  bool json = false;
};

controller::Gains gains_of(const ReplayOptions& options, const ReplayLog& log) {
  if (options.gains) return controller::read_gains(*options.gains);
  return controller::parse_gains(log.info.gains_text, options.log.string() + ": gains_text");
}

controller::Policy policy_of(const ReplayOptions& options, const ReplayLog& log, double rate_hz) {
  if (options.policy) return controller::read_policy(*options.policy, rate_hz);
  for (const LoopSession& session : log.sessions) {
    if (session.checkpoints.empty()) continue;
    const std::string& text = session.checkpoints.begin()->second.policy_text;
    if (!text.empty()) {
      return controller::parse_policy(text, options.log.string() + ": policy_text", rate_hz);
    }
  }
  return controller::default_policy(rate_hz);
}

Json to_json(const ReplayLog& log, const ReplayResult& result) {
  Json first = nullptr;
  if (result.first) {
    first = {{"channel", result.first->channel},  {"seq", result.first->seq},
             {"period", result.first->period},    {"field", result.first->field},
             {"leg", result.first->leg},          {"recorded", result.first->recorded},
             {"computed", result.first->computed}};
  }
  return {{"run_id", std::to_string(log.info.run_id)},
          {"mode", log.info.mode},
          {"n_commands", result.n_commands},
          {"n_different", result.n_different},
          {"n_periods", result.n_periods},
          {"n_gaps", result.n_gaps},
          {"n_not_computed", result.n_not_computed},
          {"n_not_logged", result.n_not_logged},
          {"n_other", result.n_other},
          {"n_damaged", log.n_damaged},
          {"first_difference", first}};
}

std::string first_in_words(const ReplayDifference& first, bool wall_clock) {
  std::string text =
      "The first that differs: " + first.channel + ", seq " + std::to_string(first.seq);
  if (wall_clock) text += ", period " + std::to_string(first.period);
  if (!first.leg.empty()) text += ", " + first.leg;
  return text + formatted(": %s recorded %.17g, computed %.17g\n", first.field.c_str(),
                          first.recorded, first.computed);
}

std::string to_text(const ReplayLog& log, const ReplayResult& result) {
  const auto count = [](std::int64_t n) { return static_cast<long long>(n); };
  const bool wall_clock = log.info.mode == "wall_clock";
  std::string text;
  if (!result.first) {
    text = formatted("%lld commands the same, to the bit\n", count(result.n_commands));
  } else {
    text = formatted("%lld of %lld commands differ\n", count(result.n_different),
                     count(result.n_commands));
    text += first_in_words(*result.first, wall_clock);
  }
  if (wall_clock) {
    text += formatted(
        "%lld periods compared, %lld gaps in the records, %lld records without a "
        "checkpoint before them\n",
        count(result.n_periods), count(result.n_gaps), count(result.n_not_computed));
  }
  if (result.n_not_logged > 0 && !log.commands.empty()) {
    text += formatted("%lld more have no command in the log\n", count(result.n_not_logged));
  }
  if (result.n_other > 0) {
    text += formatted("%lld commands of the log have no measurement or record in it\n",
                      count(result.n_other));
  }
  if (log.n_damaged > 0) text += formatted("%lld damaged messages\n", count(log.n_damaged));
  return text;
}

int run(const ReplayOptions& options) {
  const ReplayLog log = read_replay_log(options.log, options.run_id);
  const controller::Gains gains = gains_of(options, log);
  const controller::Policy policy = policy_of(options, log, gains.sample_rate_hz);
  const bool wall_clock = log.info.mode == "wall_clock";
  const ReplayResult result =
      wall_clock ? replay_wall_clock(log, gains, policy) : replay_lock_step(log, gains);
  if (result.n_commands == 0 && result.n_periods == 0) {
    throw InputError(options.log.string() + ": nothing in this log can be computed again");
  }
  if (options.json) {
    print(to_json(log, result));
  } else {
    std::cout << to_text(log, result);
  }
  return result.first ? exit_failed : exit_done;
}

}  // namespace

void add_replay(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  cli::Command verb =
      app.verb("replay", "Compute the commands of a log again, and compare them to the bit");
  verb.option("log", options->log, "LCM log of a run, or a flight record")
      .required()
      .type_name("LOG");
  verb.option("--gains", options->gains, "Gains file (default: the gains in the log)")
      .type_name("FILE");
  verb.option("--policy", options->policy,
              "Policy file of a wall-clock run (default: the policy in the log)")
      .type_name("FILE");
  verb.option("--run-id", options->run_id, "Which run, if the log holds several").type_name("ID");
  verb.flag("--json", options->json, "Print the result as JSON");
  verb.footer(
      "A lock-step run is computed from its measurements. A wall-clock run is computed from the\n"
      "controller's own records of every period (SF_LOOP) and of its memory (SF_CHECKPOINT), "
      "which a\n"
      "flight record holds as well; where records were lost it goes on at the next checkpoint.\n"
      "Keys of --json: run_id, mode, n_commands (computed and compared), n_different, n_periods "
      "(of a\n"
      "wall-clock loop), n_gaps, n_not_computed (records after a gap), n_not_logged (computed, "
      "but not\n"
      "in SF_COMMAND), n_other (in SF_COMMAND, but of nothing in the log), n_damaged,\n"
      "first_difference: null, or channel, seq, period, field, leg, recorded, computed.\n"
      "Exit codes: 0 the same; 2 not readable; 4 different.\n"
      "Example: stillframe replay runs/metrology_frame/active.lcm");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

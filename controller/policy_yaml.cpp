#include "controller/arming.hpp"
#include "controller/policy.hpp"
#include "controller/slow_loops.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe::controller {

namespace {

// A law makes up for at most 100 missed samples, so that a force held longer could not be taken up
// again.
constexpr std::int64_t most_held_periods = 100;
// Below 10 ms a ramp is a kick; above a minute it is a mistake rather than a ramp.
constexpr double shortest_ramp_s = 0.01, longest_ramp_s = 60;
// A fade of 10 ms was measured to move the frame 2.8 times as much as it does without control, one
// of 0.1 s no more than a longer one does (docs/safety.md).
constexpr double shortest_fade_s = 0.1;
constexpr double shortest_arming_s = 0.2;
// A ramp of fewer samples is a flight of steps; the shortest one has as many at 1 kHz.
constexpr std::int64_t fewest_of_a_ramp = 10;
constexpr double longest_record_s = 120, longest_window_s = 100;

// Of whatever has no bound of its own: a stiffness of steel as thick as an arm is 1e9 N/m.
constexpr double largest_number = 1e12;

struct Range {
  double lowest, highest;
};

void read(const YamlReader& block, const char* key, Range range, double& into) {
  if (const auto value = block.find(key)) {
    into = number_within(*value, range.lowest, range.highest);
  }
}

/// A time of so many samples at least.
void read(const YamlReader& block, const char* key, Range range, std::int64_t fewest,
          double rate_hz, double& into) {
  read(block, key, {range.lowest, slowed(range.highest, rate_hz)}, into);
  const auto value = block.find(key);
  const double shortest = static_cast<double>(fewest) / rate_hz;
  if (!value || into >= shortest) return;
  value->fail("found '" + value->text() + "', allowed at " + shortest_digits(rate_hz) +
              " Hz is a number from " + shortest_digits(shortest) + " on, " +
              std::to_string(fewest) + " samples");
}

void read_positive(const YamlReader& block, const char* key, double highest, double& into) {
  if (const auto value = block.find(key)) into = positive_up_to(*value, highest);
}

void read_positive(const YamlReader& block, const char* key, double& into) {
  if (const auto value = block.find(key)) into = positive_up_to(*value, largest_number);
}

void read_positive(const YamlReader& block, const char* key, std::optional<double>& into) {
  if (const auto value = block.find(key)) into = positive_up_to(*value, largest_number);
}

struct WholeRange {
  std::int64_t lowest, highest;
};

void read(const YamlReader& block, const char* key, WholeRange range, std::int64_t& into) {
  if (const auto value = block.find(key)) {
    into = integer_within(*value, range.lowest, range.highest);
  }
}

void read_arming(const YamlReader& block, double rate_hz, Policy& policy) {
  block.allow_only({"duration_s", "require_motion", "offset_limit_n"});
  read(block, "duration_s", Range{shortest_arming_s, longest_ramp_s}, Arming::n_batches, rate_hz,
       policy.arming_s);
  if (const auto value = block.find("require_motion")) policy.require_motion = value->boolean();
  read_positive(block, "offset_limit_n", policy.offset_limit_n);
}

void read_ramp(const YamlReader& block, double rate_hz, Policy& policy) {
  block.allow_only({"in_s", "out_s"});
  const Range range{shortest_ramp_s, longest_ramp_s};
  read(block, "in_s", range, fewest_of_a_ramp, rate_hz, policy.ramp_in_s);
  read(block, "out_s", range, fewest_of_a_ramp, rate_hz, policy.ramp_out_s);
}

void read_measurements(const YamlReader& block, double rate_hz, Policy& policy) {
  block.allow_only({"hold_periods", "fade_s", "missing_part", "late_periods", "sigma_limit_n"});
  read(block, "hold_periods", WholeRange{0, most_held_periods}, policy.hold_periods);
  read(block, "fade_s", Range{shortest_fade_s, longest_ramp_s}, fewest_of_a_ramp, rate_hz,
       policy.fade_s);
  read_positive(block, "missing_part", 1, policy.missing_part);
  read_positive(block, "late_periods", 100, policy.late_periods);
  read_positive(block, "sigma_limit_n", policy.sigma_limit_n);
}

void read_watch(const YamlReader& block, Policy& policy) {
  block.allow_only({"limited_part", "disobeyed_part"});
  read_positive(block, "limited_part", 1, policy.limited_part);
  read_positive(block, "disobeyed_part", 1, policy.disobeyed_part);
}

void read_limits(const YamlReader& block, Policy& policy) {
  block.allow_only(
      {"force_n", "rate_n_per_s", "free_rate_n_per_s", "power_w", "actuator_stiffness_n_per_m"});
  read_positive(block, "force_n", policy.force_limit_n);
  read_positive(block, "rate_n_per_s", policy.rate_limit_n_per_s);
  read_positive(block, "free_rate_n_per_s", policy.free_rate_n_per_s);
  read_positive(block, "power_w", policy.power_limit_w);
  read_positive(block, "actuator_stiffness_n_per_m", policy.actuator_stiffness_n_per_m);
  if (policy.power_limit_w.has_value() != policy.actuator_stiffness_n_per_m.has_value()) {
    block.fail("found only one of power_w and actuator_stiffness_n_per_m, allowed is both or none");
  }
}

void read_realtime(const YamlReader& block, Policy& policy) {
  block.allow_only({"mode", "priority", "cpu"});
  if (const auto value = block.find("mode")) {
    policy.realtime = realtime_named(value->one_of({"off", "best_effort", "enforce"}));
  }
  read(block, "priority", WholeRange{2, 98}, policy.priority);
  if (block.find("cpu")) read(block, "cpu", WholeRange{0, 1023}, policy.cpu.emplace());
}

void read_excitation(const YamlReader& block, double rate_hz, ExcitationPlan& plan) {
  plan.place = block.place();
  block.allow_only({"kind", "loop", "force_n", "from_hz", "to_hz", "window_s", "windows", "lines"});
  if (const auto value = block.find("kind")) {
    const std::string word = value->one_of({"none", "multisine", "sweep", "step"});
    using Kind = ExcitationPlan::Kind;
    plan.kind = word == "multisine" ? Kind::multisine
                : word == "sweep"   ? Kind::sweep
                : word == "step"    ? Kind::step
                                    : Kind::none;
  }
  if (const auto value = block.find("loop")) {
    plan.open_loop = value->one_of({"closed", "open"}) == "open";
  }
  read_positive(block, "force_n", plan.force_n);
  read_positive(block, "from_hz", plan.from_hz);
  read_positive(block, "to_hz", plan.to_hz);
  read_positive(block, "window_s", slowed(longest_window_s, rate_hz), plan.window_s);
  read(block, "windows", WholeRange{1, 1000}, plan.windows);
  read(block, "lines", WholeRange{1, 200}, plan.lines);
}

Policy read(const YamlReader& root, double rate_hz) {
  root.allow_only({"start", "arming", "ramp", "measurements", "watch", "rejoin", "limits",
                   "realtime", "flight_record", "excitation"});
  Policy policy = default_policy(rate_hz);
  if (const auto value = root.find("start")) {
    policy.start_at_once = value->one_of({"at_once", "on_request"}) == "at_once";
  }
  if (const auto block = root.find("arming")) read_arming(*block, rate_hz, policy);
  if (const auto block = root.find("ramp")) read_ramp(*block, rate_hz, policy);
  if (const auto block = root.find("measurements")) read_measurements(*block, rate_hz, policy);
  if (const auto block = root.find("watch")) read_watch(*block, policy);
  if (const auto block = root.find("rejoin")) {
    block->allow_only({"a_minute"});
    read(*block, "a_minute", WholeRange{0, 1000}, policy.rejoins_a_minute);
  }
  if (const auto block = root.find("limits")) read_limits(*block, policy);
  if (const auto block = root.find("realtime")) read_realtime(*block, policy);
  if (const auto block = root.find("flight_record")) {
    block->allow_only({"duration_s", "most_files", "most_mb"});
    read_positive(*block, "duration_s", slowed(longest_record_s, rate_hz), policy.record_s);
    read(*block, "most_files", WholeRange{1, 100000}, policy.record_files);
    read_positive(*block, "most_mb", policy.record_mb);
  }
  if (const auto block = root.find("excitation")) {
    read_excitation(*block, rate_hz, policy.excitation);
  }
  return policy;
}

}  // namespace

Policy default_policy(double sample_rate_hz) {
  Policy policy;
  for (double* seconds : {&policy.arming_s, &policy.ramp_in_s, &policy.ramp_out_s, &policy.fade_s,
                          &policy.record_s, &policy.excitation.window_s}) {
    *seconds = slowed(*seconds, sample_rate_hz);
  }
  return policy;
}

Policy read_policy(const std::filesystem::path& path, double sample_rate_hz) {
  return read(YamlReader::from_file(path), sample_rate_hz);
}

Policy parse_policy(const std::string& text, const std::string& source_name,
                    double sample_rate_hz) {
  return read(YamlReader::from_text(text, source_name), sample_rate_hz);
}

}  // namespace stillframe::controller

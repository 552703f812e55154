#include "controller/gains.hpp"

#include <numbers>
#include <set>

#include "core/yaml/instruments_block.hpp"

namespace stillframe::controller {

using Eigen::Index;

namespace {

std::vector<std::string> read_legs(const YamlReader& reader) {
  std::vector<std::string> legs;
  std::set<std::string> seen;
  for (const YamlReader& item : reader.items()) {
    const std::string leg = item.text();
    if (!seen.insert(leg).second) item.fail("found \"" + leg + "\" twice, leg names are unique");
    legs.push_back(leg);
  }
  if (legs.empty()) reader.fail("found an empty list, allowed is one leg name or more");
  return legs;
}

constexpr double two_pi = 2 * std::numbers::pi;

Realisation read_realisation(const YamlReader& reader) {
  const auto implicit = to_text(Realisation::implicit_feedthrough);
  const auto naive = to_text(Realisation::naive_pi);
  return reader.one_of({implicit, naive}) == implicit ? Realisation::implicit_feedthrough
                                                      : Realisation::naive_pi;
}

std::optional<double> read_optional_positive(const YamlReader& reader, const std::string& key) {
  const auto found = reader.find(key);
  if (!found) return std::nullopt;
  return found->positive();
}

PassivePlant read_plant(const YamlReader& reader, Index n_legs) {
  reader.allow_only({"A", "B", "C"});
  const YamlReader A = reader.require("A");
  const auto n = static_cast<Index>(A.items().size());
  if (n == 0) A.fail("found no rows, the plant has one state or more");
  return {.A = A.matrix(n, n),
          .B = reader.require("B").matrix(n, n_legs),
          .C = reader.require("C").matrix(n_legs, n)};
}

Gains read(const YamlReader& reader) {
  const YamlReader version = reader.require("stillframe_gains");
  if (version.integer(1) != 1) version.fail("found " + version.text() + ", allowed is 1");
  reader.allow_only({"stillframe_gains", "scene_hash", "legs", "sample_rate_hz", "delay_samples",
                     "target_hz", "realisation", "leak_hz", "high_pass_hz", "lead_samples",
                     "roll_off_hz", "force_limit_n", "instruments", "K_P", "K_I", "plant"});
  Gains gains;
  gains.scene_hash = reader.require("scene_hash").text();
  gains.legs = read_legs(reader.require("legs"));
  gains.sample_rate_hz = reader.require("sample_rate_hz").positive();
  gains.delay_samples = reader.require("delay_samples").non_negative();
  if (const auto targets = reader.find("target_hz")) {
    for (const YamlReader& target : targets->items()) {
      gains.target_hz.push_back(target.positive());
    }
  }
  gains.realisation = read_realisation(reader.require("realisation"));
  gains.leak_hz = reader.require("leak_hz").non_negative();
  if (const auto corner = reader.find("high_pass_hz")) gains.high_pass_hz = corner->non_negative();
  if (const auto lead = reader.find("lead_samples")) gains.lead_samples = lead->non_negative();
  gains.roll_off_hz = read_optional_positive(reader, "roll_off_hz");
  gains.force_limit_n = read_optional_positive(reader, "force_limit_n");
  if (const auto block = reader.find("instruments")) gains.instruments = read_instruments(*block);
  gains.K_P = reader.require("K_P").matrix(gains.n_legs(), gains.n_legs());
  gains.K_I = reader.require("K_I").matrix(gains.n_legs(), gains.n_legs());
  gains.plant = read_plant(reader.require("plant"), gains.n_legs());
  return gains;
}

}  // namespace

std::string_view to_text(Realisation realisation) {
  return realisation == Realisation::implicit_feedthrough ? "implicit_feedthrough" : "naive_pi";
}

ForceFeedback Gains::feedback() const {
  return {.K_P = K_P,
          .K_I = K_I,
          .leak = two_pi * leak_hz,
          .high_pass = two_pi * high_pass_hz,
          .roll_off = two_pi * roll_off_hz.value_or(0.0)};
}

LawSampling Gains::law_sampling() const {
  return {.realisation = realisation,
          .sample_time = sample_time(),
          .lead_samples = lead_samples,
          .sensor_filter_hz = instruments.sensor_filter_hz};
}

Sampling Gains::sampling() const {
  return {.sample_time = sample_time(),
          .delay_samples = delay_samples,
          .instruments = instruments,
          .leg_gains = {},
          .leg_delays = {}};
}

Gains read_gains(const std::filesystem::path& path) { return read(YamlReader::from_file(path)); }

Gains parse_gains(const std::string& text, const std::string& source_name) {
  return read(YamlReader::from_text(text, source_name));
}

}  // namespace stillframe::controller

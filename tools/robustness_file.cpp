#include "tools/robustness_file.hpp"

#include <fstream>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"

namespace stillframe::tools {

using robustness::Case;
using robustness::Extremes;
using robustness::Histogram;
using robustness::Measure;
using robustness::Outcome;
using robustness::Record;
using robustness::Tally;

namespace {

constexpr const char* file_format = "stillframe robustness";
constexpr int version = 3;

/// The keys under which the samples that are worst by each measure stand.
constexpr const char* worst_keys[] = {"spectral_radius", "least_damping_ratio", "peak"};

Json pair(const Extremes& extremes) { return {extremes.least, extremes.most}; }

double number(const Json& value, double instead_of_null) {
  return value.is_null() ? instead_of_null : value.get<double>();
}

Extremes extremes_from(const Json& pair) {
  const Extremes empty;
  return {number(pair.at(0), empty.least), number(pair.at(1), empty.most)};
}

Json bins(const Histogram& histogram) {
  Json counts = Json::array();
  const int first = histogram.counts.empty() ? 0 : histogram.counts.begin()->first;
  for (const auto& [bin, count] : histogram.counts) {
    while (first + static_cast<int>(counts.size()) < bin) counts.push_back(0);
    counts.push_back(count);
  }
  return {{"width", histogram.width}, {"first_bin", first}, {"counts", counts}};
}

/// The library would make a huge one of -1.
std::uint64_t count_from(const Json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  throw InputError("found " + value.dump() + " as a count, allowed are whole numbers from 0 up");
}

void read_counts(const Json& value, Histogram& histogram) {
  if (value.at("width").get<double>() != histogram.width) {
    throw InputError("a histogram has another width of its bins");
  }
  int bin = value.at("first_bin").get<int>();
  for (const Json& count : value.at("counts")) {
    if (const std::uint64_t n = count_from(count); n > 0) histogram.counts[bin] = n;
    ++bin;
  }
}

Json entry(const Case& sample) {
  return {{"index", sample.index},
          {"spectral_radius", sample.radius},
          {"least_damping_ratio", sample.damping},
          {"peak", sample.peak},
          {"values", to_json(sample.values)}};
}

Eigen::VectorXd vector_from(const Json& list) {
  const auto values = list.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Case case_from(const Json& value) {
  return {.index = value.at("index").get<std::uint64_t>(),
          .values = vector_from(value.at("values")),
          .radius = value.at("spectral_radius").get<double>(),
          .damping = value.at("least_damping_ratio").get<double>(),
          .peak = number(value.at("peak"), std::numeric_limits<double>::quiet_NaN())};
}

void add_tally(const Tally& tally, Json& document) {
  document["counts"] = {
      {"stable", tally.n_stable}, {"unstable", tally.n_unstable}, {"failed", tally.n_failed()}};
  document["failures"] = Json(tally.failures);
  Json gain = Json::array(), gain_db = Json::array(), highest = gain, highest_db = gain, worst;
  for (const Extremes& extremes : tally.gain) gain.push_back(pair(extremes));
  for (const Histogram& histogram : tally.gain_db) gain_db.push_back(bins(histogram));
  for (const Extremes& extremes : tally.highest) highest.push_back(pair(extremes));
  for (const Histogram& histogram : tally.highest_db) highest_db.push_back(bins(histogram));
  for (const Measure measure : robustness::measures) {
    const auto m = static_cast<size_t>(measure);
    worst[worst_keys[m]] = Json::array();
    for (const Case& sample : tally.worst[m]) worst[worst_keys[m]].push_back(entry(sample));
  }
  document["extremes"] = {{"spectral_radius", pair(tally.radius)},
                          {"least_damping_ratio", pair(tally.damping)},
                          {"peak", pair(tally.peak)},
                          {"largest_singular_values", gain},
                          {"highest_singular_values", highest}};
  document["histograms"] = {{"log10_decay_per_s", bins(tally.decay)},
                            {"log10_negative_damping_ratio", bins(tally.least_damping.below)},
                            {"log10_damping_ratio", bins(tally.least_damping.above)},
                            {"peak_db", bins(tally.peak_db)},
                            {"largest_singular_values_db", gain_db},
                            {"highest_singular_values_db", highest_db}};
  document["worst_samples"] = worst;
}

Tally tally_from(const Json& document, size_t n_frequencies) {
  Tally tally(n_frequencies);
  tally.n_stable = count_from(document.at("counts").at("stable"));
  tally.n_unstable = count_from(document.at("counts").at("unstable"));
  for (const auto& [why, count] : document.at("failures").items()) {
    tally.failures[why] = count_from(count);
  }
  const Json& extremes = document.at("extremes");
  const Json& histograms = document.at("histograms");
  tally.radius = extremes_from(extremes.at("spectral_radius"));
  tally.damping = extremes_from(extremes.at("least_damping_ratio"));
  tally.peak = extremes_from(extremes.at("peak"));
  read_counts(histograms.at("log10_decay_per_s"), tally.decay);
  read_counts(histograms.at("log10_negative_damping_ratio"), tally.least_damping.below);
  read_counts(histograms.at("log10_damping_ratio"), tally.least_damping.above);
  read_counts(histograms.at("peak_db"), tally.peak_db);
  for (size_t i = 0; i < n_frequencies; ++i) {
    tally.gain[i] = extremes_from(extremes.at("largest_singular_values").at(i));
    read_counts(histograms.at("largest_singular_values_db").at(i), tally.gain_db[i]);
    tally.highest[i] = extremes_from(extremes.at("highest_singular_values").at(i));
    read_counts(histograms.at("highest_singular_values_db").at(i), tally.highest_db[i]);
  }
  for (const Measure measure : robustness::measures) {
    const auto m = static_cast<size_t>(measure);
    for (const Json& sample : document.at("worst_samples").at(worst_keys[m])) {
      tally.worst[m].push_back(case_from(sample));
    }
  }
  return tally;
}

Json keys(const SceneUncertainty& uncertainty) {
  return {{"stiffness", uncertainty.stiffness},
          {"damping", uncertainty.damping},
          {"mass", uncertainty.mass},
          {"inertia", uncertainty.inertia},
          {"centre_of_mass_m", uncertainty.centre_of_mass_m},
          {"leg_direction_rad", uncertainty.leg_direction_rad},
          {"actuator_gain", uncertainty.actuator_gain},
          {"sensor_gain", uncertainty.sensor_gain},
          {"delay_samples", uncertainty.delay_samples}};
}

SceneUncertainty uncertainty_from(const Json& value) {
  SceneUncertainty uncertainty;
  uncertainty.stiffness = value.at("stiffness");
  // These two came later: a record without them varied neither.
  uncertainty.damping = value.value("damping", 0.0);
  uncertainty.sensor_gain = value.value("sensor_gain", 0.0);
  uncertainty.mass = value.at("mass");
  uncertainty.inertia = value.at("inertia");
  uncertainty.centre_of_mass_m = value.at("centre_of_mass_m");
  uncertainty.leg_direction_rad = value.at("leg_direction_rad");
  uncertainty.actuator_gain = value.at("actuator_gain");
  uncertainty.delay_samples = value.at("delay_samples");
  return uncertainty;
}

void require_format(const Json& document) {
  const bool has = document.contains("format");
  if (has && document.at("format") == file_format) return;
  throw InputError(
      "it is no robustness record: " +
      (has ? "its format is " + document.at("format").dump() : std::string("it has no format")) +
      ", allowed is \"" + file_format + "\", as `stillframe robustness --out` writes it");
}

/// Every sample of the shards counts once, and every stable one in each histogram.
void require_counts(const Record& record) {
  const Tally& tally = record.tally;
  std::uint64_t n = 0;
  for (const std::uint64_t shard : record.shards) {
    if (shard < 1 || shard > record.n_shards) {
      throw InputError("shards: found " + std::to_string(shard) + ", allowed are 1 to " +
                       std::to_string(record.n_shards));
    }
    n += robustness::Shard{shard, record.n_shards}.size(record.samples);
  }
  const auto require = [](const std::string& what, std::uint64_t found, std::uint64_t wanted) {
    if (found == wanted) return;
    throw InputError("its numbers contradict each other: " + what + " are " +
                     std::to_string(found) + ", and " + std::to_string(wanted) +
                     " samples belong there; write it anew with `stillframe robustness --out`");
  };
  require("stable, unstable and failed", tally.n_samples(), n);
  require("those in log10_decay_per_s", tally.decay.total(), tally.n_stable);
  require("those in the damping ratios", tally.least_damping.total(),
          tally.n_stable + tally.n_unstable);
  require("those in peak_db", tally.peak_db.total(), tally.n_stable);
  for (const auto* histograms : {&tally.gain_db, &tally.highest_db}) {
    for (const Histogram& histogram : *histograms) {
      require("those in a histogram of singular values", histogram.total(), tally.n_stable);
    }
  }
}

Record record_from(const Json& document) {
  require_format(document);
  if (document.at("version") != version) {
    throw InputError("it is of version " + document.at("version").dump() + ", allowed is " +
                     std::to_string(version));
  }
  Record record;
  record.scene = document.at("scene");
  record.scene_hash = document.at("scene_hash");
  record.uncertainty = uncertainty_from(document.at("uncertainty"));
  record.parameters = document.at("parameters").get<std::vector<std::string>>();
  record.frequencies_hz = vector_from(document.at("frequencies_hz"));
  record.sample_time = document.at("sample_time_s");
  record.seed = document.at("seed");
  record.samples = count_from(document.at("n_samples"));
  record.n_shards = count_from(document.at("shards").at("n_shards"));
  record.shards = document.at("shards").at("done").get<std::set<std::uint64_t>>();
  const Json& nominal = document.at("nominal");
  record.nominal.verdict = Outcome::Verdict::stable;
  record.nominal.radius = nominal.at("spectral_radius");
  record.nominal.damping = nominal.at("least_damping_ratio");
  record.nominal.decay = nominal.at("decay_per_s");
  record.nominal.peak = nominal.at("peak");
  record.nominal.gain = vector_from(nominal.at("largest_singular_values"));
  record.tally = tally_from(document, static_cast<size_t>(record.frequencies_hz.size()));
  if (record.nominal.gain.size() != record.frequencies_hz.size()) {
    throw InputError("there are not as many nominal singular values as frequencies");
  }
  require_counts(record);
  return record;
}

/// Without the library's number, "[json.exception.type_error.302] ".
std::string in_words(const Json::exception& error) {
  const std::string text = error.what();
  return text.substr(text.find(' ') + 1);
}

}  // namespace

Json to_json(const Outcome& outcome) {
  Json value{{"verdict", outcome.verdict == Outcome::Verdict::stable     ? "stable"
                         : outcome.verdict == Outcome::Verdict::unstable ? "unstable"
                                                                         : "failed"}};
  if (outcome.verdict == Outcome::Verdict::failed) {
    value["failure"] = outcome.failure;
    return value;
  }
  value["spectral_radius"] = outcome.radius;
  value["least_damping_ratio"] = outcome.damping;
  value["decay_per_s"] = outcome.decay;
  if (outcome.verdict == Outcome::Verdict::unstable) return value;
  value["peak"] = outcome.peak;
  value["largest_singular_values"] = to_json(outcome.gain);
  return value;
}

Json to_json(const Record& record) {
  Json document{{"format", file_format},
                {"version", version},
                {"scene", record.scene},
                {"scene_hash", record.scene_hash},
                {"uncertainty", keys(record.uncertainty)},
                {"seed", record.seed},
                {"n_samples", record.samples},
                {"shards", {{"n_shards", record.n_shards}, {"done", record.shards}}},
                {"sample_time_s", record.sample_time},
                {"frequencies_hz", to_json(record.frequencies_hz)},
                {"parameters", record.parameters},
                {"nominal", to_json(record.nominal)}};
  add_tally(record.tally, document);
  return document;
}

Record read_record(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::error_code ignored;
  if (!file || std::filesystem::is_directory(path, ignored)) {
    throw InputError(path.string() + ": cannot be read");
  }
  try {
    return record_from(Json::parse(file));
  } catch (const Json::exception& error) {
    throw InputError(path.string() + ": is no robustness record: " + in_words(error));
  } catch (const InputError& error) {
    throw InputError(path.string() + ": " + error.what());
  }
}

void write_record(const Record& record, const std::filesystem::path& path) {
  write_whole_file(path, text_of(to_json(record)));
}

}  // namespace stillframe::tools

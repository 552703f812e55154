#include "tests/faults/table.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

#include "core/numerics/worst.hpp"

namespace stillframe::faults {

namespace {

bool is_allowed(const KindResult& result, const std::string& outcome) {
  return std::find(result.allowed.begin(), result.allowed.end(), outcome) != result.allowed.end();
}

bool is_latched(const std::string& outcome) { return outcome.find("latched") != std::string::npos; }

std::string shown(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string outcomes(const KindResult& result) {
  std::map<std::string, int> times;
  int disturbed = 0;
  for (const Episode& episode : result.episodes) {
    ++times[episode.outcome];
    disturbed += episode.disturbed ? 1 : 0;
  }
  std::string text;
  for (const auto& [outcome, n] : times) {
    text += (text.empty() ? "" : "; ") + std::to_string(n) + " " + outcome;
  }
  return text + (disturbed > 0 ? " (" + std::to_string(disturbed) + " disturbed)" : "");
}

template <class Member>
double largest(const KindResult& result, Member member) {
  double value = 0;
  for (const Episode& episode : result.episodes) value = worst_of(value, episode.*member);
  return value;
}

std::string recoveries(const KindResult& result) {
  if (result.episodes.empty()) return "";
  std::vector<std::int64_t> all;
  for (const Episode& episode : result.episodes) all.push_back(episode.recovery);
  std::sort(all.begin(), all.end());
  return std::to_string(all[all.size() / 2]) + ", " + std::to_string(all.back());
}

}  // namespace

std::vector<std::string> failures(const KindResult& result) {
  std::vector<std::string> all;
  if (!result.trouble.empty()) return {result.name + ": " + result.trouble};
  for (const Episode& episode : result.episodes) {
    const std::string where = result.name + ", seed " + std::to_string(episode.seed) + ": ";
    const bool allowed = is_allowed(result, episode.outcome);
    if (!allowed && (!episode.disturbed || is_latched(episode.outcome))) {
      all.push_back(where + "the outcome was '" + episode.outcome + "'; " + episode.lateness);
    }
    // The frame is never driven harder than it would be without control; NaN fails as well.
    // Where the machine has made the loop let go once more, the frame that is left to itself is no
    // longer the one to compare with; each letting go adds at most one such motion (the frame is
    // linear), so twice the peak.
    if (!(episode.over_passive <= (episode.disturbed ? 2.0 : result.at_most))) {
      all.push_back(where + "peak active over passive " + shown("%.3f", episode.over_passive));
    }
    // The model is linear and exact, the plant's integrator errs by 1e-5 within a sample.
    if (!(episode.model_error < 0.01)) {
      all.push_back(where + "the frame left to itself is not that of the plant: " +
                    shown("%.3g", episode.model_error));
    }
    // A loop that wakes up late within its period may find two measurements in it, once or twice
    // without a period that was missing.
    const bool too_many = !episode.disturbed && episode.n_counted > episode.n_at_most + 2;
    const bool too_few = !episode.disturbed && episode.n_counted < episode.n_inflicted;
    if (too_few || too_many) {
      all.push_back(where + "the relay made " + std::to_string(episode.n_inflicted) +
                    ", the controller counted " + std::to_string(episode.n_counted) + ", at most " +
                    std::to_string(episode.n_at_most) + " are due to the machine");
    }
  }
  // The controller's word for a plant that failed.
  if (result.exit_code != 4) all.push_back(result.name + ": the controller did not end with 4");
  return all;
}

std::string markdown(const std::vector<KindResult>& results) {
  std::string text =
      "| fault | outcome of the episodes | active again after, samples: median, longest | peak "
      "over passive | over always passive, a minute | the same, same samples | over left to "
      "itself |\n|---|---|---|---|---|---|---|\n";
  for (const KindResult& result : results) {
    text += "| " + result.name + " | " + outcomes(result) + " | " + recoveries(result);
    for (const auto member : {&Episode::over_passive, &Episode::over_minute, &Episode::over_same,
                              &Episode::over_left}) {
      text += " | " + shown("%.2f", largest(result, member));
    }
    text += " |\n";
  }
  return text;
}

nlohmann::json to_json(const std::vector<KindResult>& results) {
  nlohmann::json rows = nlohmann::json::array();
  for (const KindResult& result : results) {
    nlohmann::json episodes = nlohmann::json::array();
    for (const Episode& episode : result.episodes) {
      episodes.push_back({{"seed", episode.seed},
                          {"outcome", episode.outcome},
                          {"recovery_samples", episode.recovery},
                          {"over_passive", episode.over_passive},
                          {"over_minute", episode.over_minute},
                          {"over_same_samples", episode.over_same},
                          {"over_left", episode.over_left},
                          {"model_error", episode.model_error},
                          {"disturbed", episode.disturbed},
                          {"n_inflicted", episode.n_inflicted},
                          {"n_counted", episode.n_counted},
                          {"n_at_most", episode.n_at_most}});
    }
    rows.push_back({{"name", result.name},
                    {"allowed", result.allowed},
                    {"exit_code", result.exit_code ? nlohmann::json(*result.exit_code) : nullptr},
                    {"trouble", result.trouble},
                    {"episodes", episodes}});
  }
  return rows;
}

}  // namespace stillframe::faults

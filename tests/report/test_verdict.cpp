#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "report/identification/comparison.hpp"
#include "report/log/run_log.hpp"
#include "report/said_once.hpp"
#include "report/verdict/verdict.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using nlohmann::json;

MotionLevel level(double rms, double velocity, double hz, const std::string& name) {
  return {.rms_acceleration = rms,
          .largest_band_velocity = velocity,
          .largest_band_hz = hz,
          .vibration_class = name};
}

Verdict sample_verdict() {
  Verdict verdict;
  verdict.runs = {{.scene_name = "metrology_frame",
                   .scene_hash = "0123456789abcdef",
                   .program_version = "0.1.0",
                   .mode = "lock_step",
                   .loop = "passive",
                   .sample_rate_hz = 1000,
                   .delay_samples = 1,
                   .n_samples = 390000,
                   .n_commands = 390000,
                   .real_time_factor = 11.25},
                  {.scene_name = "metrology_frame",
                   .scene_hash = "0123456789abcdef",
                   .program_version = "0.1.0",
                   .mode = "lock_step",
                   .loop = "active",
                   .sample_rate_hz = 1000,
                   .delay_samples = 1,
                   .n_samples = 390000,
                   .n_duplicates = 2,
                   .n_commands = 390000}};
  verdict.timing = {{.loop = "active",
                     .source = "controller",
                     .n_periods = 390000,
                     .n_late = 3,
                     .worst_wake_up_us = 81.25,
                     .worst_compute_us = 4.5}};
  verdict.identification = IdentificationSummary{.n_frequencies = 40,
                                                 .lowest_hz = 1,
                                                 .highest_hz = 100,
                                                 .n_open_compared = 240,
                                                 .n_closed_compared = 240,
                                                 .allowed_db = 0.2,
                                                 .open_largest_db = 0.0123,
                                                 .open_at_hz = 14.5,
                                                 .closed_largest_db = 0.1,
                                                 .closed_at_hz = 80,
                                                 .beyond_db = 0.02,
                                                 .reduction_above_hz = 10,
                                                 .n_reduction_frequencies = 22,
                                                 .n_closed_below_open = 22,
                                                 .reduction_largest_error_db = 0.11};
  verdict.axes = {{"x", level(1e-3, 6.2e-6, 12.5, "VC-D"), level(8e-3, 4e-5, 12.5, "VC-A"),
                   level(0.1e-3, 3e-6, 1, "VC-E")},
                  {"z", level(2e-3, 6.1e-6, 10, "VC-D"), std::nullopt, std::nullopt}};
  verdict.axes[0].asked = {{.asked = {.axis = "x", .from_hz = 10, .rms_of_floor = 0.5},
                            .by_scene = true,
                            .why_not = {},
                            .floor = 0.9e-3,
                            .passive = {},
                            .active = 0.09e-3}};
  verdict.warnings = {"a warning"};
  verdict.judgement = conclude({{.subject = Subject::effort,
                                 .what = "commands with a limited force",
                                 .asked = "none",
                                 .found = "7",
                                 .outcome = Outcome::failed,
                                 .reason = "Forces were limited."}});
  return verdict;
}

TEST(Verdict, TheIdentificationPassesOnlyIfNothingIsWrong) {
  const auto passes = [](auto change) {
    Verdict verdict = sample_verdict();
    change(*verdict.identification);
    return verdict.identification->outcome() == Outcome::passed;
  };
  using Id = IdentificationSummary;
  EXPECT_TRUE(passes([](Id&) {}));
  EXPECT_TRUE(passes([](Id& id) { id.open_largest_db = 0.9; }));
  EXPECT_FALSE(passes([](Id& id) { id.beyond_db = 0.21; }));
  EXPECT_FALSE(passes([](Id& id) { id.beyond_db = std::nan(""); }));
  EXPECT_FALSE(passes([](Id& id) { id.n_closed_below_open = 21; }));
  EXPECT_FALSE(passes([](Id& id) { id.n_frequencies = 0; }));
  EXPECT_FALSE(passes([](Id& id) { id.n_open_compared = id.n_closed_compared = 0; }));
}

// Values of one loop say nothing of the other, and what is known nowhere need not be so nowhere.
TEST(Verdict, OfEachLoopAndOfItsReductionSomethingHasToBeKnown) {
  const auto outcome = [](auto change) {
    Verdict verdict = sample_verdict();
    change(*verdict.identification);
    return verdict.identification->outcome();
  };
  using Id = IdentificationSummary;
  const auto nothing_reduced = [](Id& id) {
    id.n_reduction_frequencies = id.n_closed_below_open = 0;
  };
  EXPECT_EQ(outcome([](Id& id) { id.n_closed_compared = 0; }), Outcome::not_judged);
  EXPECT_EQ(outcome([](Id& id) { id.n_open_compared = 0; }), Outcome::not_judged);
  EXPECT_EQ(outcome(nothing_reduced), Outcome::passed) << "predicted nowhere";
  EXPECT_EQ(outcome([&](Id& id) {
              nothing_reduced(id);
              id.n_reduction_unknown = 3;
            }),
            Outcome::not_judged)
      << "known nowhere";
  EXPECT_EQ(outcome([](Id& id) { id.n_reduction_unknown = 3; }), Outcome::passed);
  // What is known and wrong fails all the same.
  EXPECT_EQ(outcome([](Id& id) {
              id.n_closed_compared = 0;
              id.beyond_db = 0.21;
            }),
            Outcome::failed);
  EXPECT_EQ(outcome([](Id& id) {
              id.beyond_db = 0.21;
              id.forces_unknown = true;
            }),
            Outcome::not_judged);
}

TEST(Verdict, JsonReadsBackToTheSameNumbers) {
  Verdict verdict = sample_verdict();
  verdict.identification->open_largest_db = std::nextafter(0.0123, 1);
  verdict.identification->closed_at_hz = std::nan("");
  const json j = json::parse(to_json(verdict));
  EXPECT_EQ(j["format"], 3);
  EXPECT_EQ(j["outcome"], "failed");
  EXPECT_EQ(j["checks"][0]["outcome"], "failed");
  EXPECT_EQ(j["axes"][0]["ranges"][0]["active_rms_m_s2"], 0.09e-3);
  EXPECT_TRUE(j["axes"][0]["ranges"][0]["passive_rms_m_s2"].is_null());
  EXPECT_EQ(j["runs"].size(), 2u);
  EXPECT_EQ(j["runs"][0]["loop"], "passive");
  EXPECT_EQ(j["runs"][0]["n_samples"], 390000);
  EXPECT_EQ(j["runs"][0]["real_time_factor"], 11.25);
  EXPECT_TRUE(j["runs"][1]["real_time_factor"].is_null());
  EXPECT_EQ(j["timing"][0]["worst_wake_up_us"], 81.25);
  EXPECT_EQ(j["identification"]["open_largest_db"].get<double>(), std::nextafter(0.0123, 1));
  EXPECT_TRUE(j["identification"]["closed_at_hz"].is_null());
  EXPECT_EQ(j["axes"][0]["active"]["vibration_class"], "VC-E");
  EXPECT_EQ(j["axes"][0]["ratio_active_to_passive"]["rms"], 0.1e-3 / 8e-3);
  EXPECT_EQ(j["axes"][0]["ratio_active_to_floor"]["largest_band"], 3e-6 / 6.2e-6);
  EXPECT_FALSE(j["axes"][1].contains("active"));
  verdict.identification.reset();
  EXPECT_FALSE(json::parse(to_json(verdict)).contains("identification"));
}

TEST(Verdict, EveryKeyIsDocumented) {
  std::ifstream file(STILLFRAME_SOURCE_DIR "/docs/json/verdict.schema.json");
  const std::string documentation((std::istreambuf_iterator<char>(file)), {});
  const json flat = json::parse(to_json(sample_verdict())).flatten();
  for (const auto& entry : flat.items()) {
    std::istringstream parts(entry.key());
    for (std::string key; std::getline(parts, key, '/');) {
      if (key.empty() || std::isdigit(static_cast<unsigned char>(key.front()))) continue;
      EXPECT_NE(documentation.find('"' + key + '"'), std::string::npos) << key;
    }
  }
}

TEST(Verdict, TextIsAlignedAndSaysItAll) {
  const std::string page = to_text(sample_verdict());
  for (const char* part :
       {"Scene metrology_frame (0123456789abcdef)", "390000", "11.25", "unknown", "pass", "VC-E",
        "Warning: a warning", "Verdict: failed. Forces were limited.", "0.0125", "6.2", "81.2",
        "closed loop below open loop at 22 of the 22 frequencies above 10 Hz"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part << " in\n" << page;
  }
  // Nothing that was compared is no agreement.
  Verdict unknown = sample_verdict();
  unknown.identification->n_closed_compared = 0;
  EXPECT_NE(to_text(unknown).find("singular values, closed loop                           -"),
            std::string::npos)
      << to_text(unknown);
  // The lines of a table end in one column where their last cell is a number.
  std::istringstream lines(page);
  std::vector<std::size_t> widths;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("  passive", 0) == 0 || line.rfind("  active", 0) == 0)
      widths.push_back(line.size());
  }
  ASSERT_EQ(widths.size(), 3u);
  EXPECT_EQ(widths[0], widths[1]);
}

TEST(Verdict, WhatHoldsForSeveralIsSaidOnce) {
  SaidOnce said;
  said.add("Axis x: the run is short.");
  said.add("Nothing moves.");
  said.add("Axis y: the run is short.");
  said.add("Axis y: the run is short.");
  said.add("Axis z", "the run is long.");
  EXPECT_EQ(said.lines(), (std::vector<std::string>{"Axis x; Axis y: the run is short.",
                                                    "Nothing moves.", "Axis z: the run is long."}));
  Verdict verdict;
  for (const char* what : {"3 inputs to 2 outputs", "3 inputs to 3 outputs"}) {
    ResponseSummary response;
    response.loop = "active";
    response.what = what;
    response.missing = "they move together";
    verdict.responses.push_back(response);
  }
  EXPECT_NE(to_text(verdict).find("\n  active, 3 inputs to 2 outputs; active, 3 inputs to 3 "
                                  "outputs: they move together\n"),
            std::string::npos)
      << to_text(verdict);
}

TEST(Verdict, DamageIsSaid) {
  Verdict verdict = sample_verdict();
  verdict.runs[1].unread_bytes = 77;
  EXPECT_NE(to_text(verdict).find("77 bytes at its end"), std::string::npos);
}

TEST(Verdict, SummaryComesFromTheComparison) {
  PredictionError open, closed;
  open.largest_db = 0.05;
  open.n_compared = 5;
  closed.largest_db = 0.3;
  closed.n_compared = 4;
  closed.beyond_db = 0.25;
  open.tolerance_db = closed.tolerance_db = 0.2;
  const ReductionCheck reduction{.n_frequencies = 2, .n_below = 2, .n_unknown = 7};
  const auto id = summarise(open, closed, reduction, {1, 20, 30}, 10);
  EXPECT_EQ(id.n_frequencies, 3);
  EXPECT_EQ(id.n_compared(), 9);
  EXPECT_EQ(id.n_closed_compared, 4);
  EXPECT_EQ(id.n_reduction_unknown, 7);
  EXPECT_EQ(id.highest_hz, 30);
  EXPECT_EQ(id.open_largest_db, 0.05);
  EXPECT_EQ(id.beyond_db, 0.25);
  EXPECT_EQ(id.allowed_db, 0.2);
  EXPECT_EQ(id.outcome(), Outcome::failed);
}

TEST(Verdict, EverythingThatALogTellsIsInBoth) {
  Verdict verdict = sample_verdict();
  verdict.timing[0].wake_up = {61, 182, 4321};
  verdict.timing[0].compute = {11, 12, 13};
  verdict.axes[0].active_spectra = {{1e-6, 2e-6}, {3e-3, 4e-3}};
  verdict.responses = {{.loop = "active",
                        .what = "3 inputs to 3 outputs",
                        .method = "broadband",
                        .missing = "",
                        .n_frequencies = 50,
                        .n_compared = 137,
                        .sampled_largest_db = 0.0123,
                        .sampled_at_hz = 7.5,
                        .n_filled = 19},
                       {.loop = "passive", .what = "a matrix", .missing = "no reason"}};
  verdict.transmissibility = {
      {"x", "active", {1, 2}, {0.5, 0.25}, {0.4, 0.2}, {0.6, 0.3}, {1, 0.9}}};
  verdict.shocks = {{"x", "active", 12.5, 1e-2, 2e-3, 0.7}, {"y", "passive", 12.5, 1e-2, 2e-1, {}}};
  verdict.noise = {{"z", "active", 1.25e-6, 0.0456}, {"x", "active", {}, {}, "no model"}};
  verdict.effort = {{"active", "leg_3v", 0.75, 4.875, 4.9375, 100.0}};
  const std::string page = to_text(verdict);
  for (const char* part : {"182", "4.32e+03", "broadband", "0.0123", "no reason", "19 lost", "0.7",
                           "never", "0.0456", "4.938", "0.049"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part << "\n" << page;
  }
  const json j = json::parse(to_json(verdict));
  EXPECT_EQ(j["timing"][0]["wake_up"]["p999_us"], 4321);
  EXPECT_EQ(j["axes"][0]["active"]["third_octaves_m_s"][1], 2e-6);
  EXPECT_EQ(j["bands_hz"].size(), 20u);
  EXPECT_EQ(j["responses"][0]["n_compared"], 137);
  EXPECT_EQ(j["responses"][1]["missing"], "no reason");
  EXPECT_EQ(j["transmissibility"][0]["upper"][1], 0.3);
  EXPECT_EQ(j["shocks"][0]["settling_s"], 0.7);
  EXPECT_TRUE(j["shocks"][1]["settling_s"].is_null());
  EXPECT_EQ(j["noise"][0]["share"], 0.0456);
  EXPECT_TRUE(j["noise"][1]["rms_m_s2"].is_null());
  EXPECT_EQ(j["noise"][1]["missing"], "no model");
  EXPECT_EQ(j["effort"][0]["force_limit_n"], 100);
}

TEST(Verdict, WritesAFileOrSaysThatItCannot) {
  const test::ScratchFolder folder;
  write_json(sample_verdict(), folder / "verdict.json");
  std::ifstream file(folder / "verdict.json");
  EXPECT_EQ(json::parse(file), json::parse(to_json(sample_verdict())));
  expect_error<InputError>([&] { write_json(sample_verdict(), folder / "none" / "verdict.json"); },
                           "cannot be written");
}

}  // namespace
}  // namespace stillframe::report

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "core/yaml/input_error.hpp"
#include "report/identification/comparison.hpp"
#include "report/log/run_log.hpp"
#include "report/verdict/verdict.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"

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
                                                 .floor_db = -50,
                                                 .allowed_db = 0.2,
                                                 .open_largest_db = 0.0123,
                                                 .open_at_hz = 14.5,
                                                 .closed_largest_db = 0.1,
                                                 .closed_at_hz = 80,
                                                 .reduction_above_hz = 10,
                                                 .n_reduction_frequencies = 22,
                                                 .n_closed_below_open = 22,
                                                 .reduction_largest_error_db = 0.11};
  verdict.axes = {{"x", level(1e-3, 6.2e-6, 12.5, "VC-D"), level(8e-3, 4e-5, 12.5, "VC-A"),
                   level(0.1e-3, 3e-6, 1, "VC-E")},
                  {"z", level(2e-3, 6.1e-6, 10, "VC-D"), std::nullopt, std::nullopt}};
  return verdict;
}

TEST(Verdict, PassesOnlyIfNothingIsWrong) {
  const auto passes = [](auto change) {
    Verdict verdict = sample_verdict();
    change(verdict);
    return verdict.pass();
  };
  EXPECT_TRUE(passes([](Verdict&) {}));
  EXPECT_TRUE(passes([](Verdict& v) { v.identification.reset(); }));
  EXPECT_FALSE(passes([](Verdict& v) { v.runs.clear(); }));
  EXPECT_FALSE(passes([](Verdict& v) { v.runs[1].n_lost = 1; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.runs[0].n_damaged = 1; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.runs[0].unread_bytes = 1; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.identification->open_largest_db = 0.21; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.identification->closed_largest_db = std::nan(""); }));
  EXPECT_FALSE(passes([](Verdict& v) { v.identification->reduction_largest_error_db = 0.21; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.identification->n_closed_below_open = 21; }));
  EXPECT_FALSE(passes([](Verdict& v) { v.identification->n_frequencies = 0; }));
}

TEST(Verdict, JsonReadsBackToTheSameNumbers) {
  Verdict verdict = sample_verdict();
  verdict.identification->open_largest_db = std::nextafter(0.0123, 1);
  verdict.identification->closed_at_hz = std::nan("");
  const json j = json::parse(to_json(verdict));
  EXPECT_EQ(j["format"], 1);
  EXPECT_EQ(j["pass"], true);
  EXPECT_EQ(j["runs"].size(), 2u);
  EXPECT_EQ(j["runs"][0]["loop"], "passive");
  EXPECT_EQ(j["runs"][0]["n_samples"], 390000);
  EXPECT_EQ(j["runs"][0]["real_time_factor"], 11.25);
  EXPECT_TRUE(j["runs"][1]["real_time_factor"].is_null());
  EXPECT_EQ(j["timing"][0]["worst_wake_up_us"], 81.25);
  EXPECT_EQ(j["identification"]["open_largest_db"].get<double>(), std::nextafter(0.0123, 1));
  EXPECT_TRUE(j["identification"]["closed_at_hz"].is_null());
  EXPECT_EQ(j["axes"][0]["active"]["vibration_class"], "VC-E");
  EXPECT_EQ(j["axes"][0]["ratio_active_to_passive"]["rms_acceleration"], 0.1e-3 / 8e-3);
  EXPECT_EQ(j["axes"][0]["ratio_active_to_floor"]["largest_band_velocity"], 3e-6 / 6.2e-6);
  EXPECT_FALSE(j["axes"][1].contains("active"));
  verdict.identification.reset();
  EXPECT_FALSE(json::parse(to_json(verdict)).contains("identification"));
}

TEST(Verdict, EveryKeyIsDocumented) {
  std::ifstream file(STILLFRAME_SOURCE_DIR "/report/verdict/verdict.hpp");
  const std::string header((std::istreambuf_iterator<char>(file)), {});
  const std::string documentation = header.substr(header.find("The verdict as JSON"));
  const json flat = json::parse(to_json(sample_verdict())).flatten();
  for (const auto& entry : flat.items()) {
    std::istringstream parts(entry.key());
    for (std::string key; std::getline(parts, key, '/');) {
      if (key.empty() || std::isdigit(static_cast<unsigned char>(key.front()))) continue;
      EXPECT_NE(documentation.find(key), std::string::npos) << key;
    }
  }
}

TEST(Verdict, TextIsAlignedAndSaysItAll) {
  const std::string page = to_text(sample_verdict());
  for (const char* part : {"Scene metrology_frame (0123456789abcdef)", "390000", "11.25", "unknown",
                           "pass", "VC-E", "0.0125", "6.2", "81.2",
                           "closed loop below open loop at 22 of 22 frequencies above 10 Hz"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part << " in\n" << page;
  }
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

TEST(Verdict, FailureIsSaid) {
  Verdict verdict = sample_verdict();
  verdict.runs[1].n_lost = 4;
  verdict.runs[1].unread_bytes = 77;
  const std::string page = to_text(verdict);
  EXPECT_NE(page.find("Verdict: FAIL"), std::string::npos);
  EXPECT_NE(page.find("77 bytes at its end"), std::string::npos);
}

TEST(Verdict, MotionLevelOfASine) {
  // 2 mm/s^2 at 20 Hz (centre 19.95 Hz) for 64 s.
  const double amplitude = 2e-3, omega = 2 * std::numbers::pi * 20;
  const Eigen::VectorXd a = Eigen::VectorXd::NullaryExpr(64000, [=](Eigen::Index k) {
    return amplitude * std::sin(omega * 1e-3 * static_cast<double>(k));
  });
  const MotionLevel result = motion_level(a, 1000);
  // 20 Hz is a whole bin of 1/16 Hz, all of its main lobe lies in the band: rounding, and 1 / f
  // over the lobe.
  EXPECT_NEAR(result.rms_acceleration, amplitude / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(result.largest_band_velocity, amplitude / omega / std::sqrt(2.0), 1e-9);
  EXPECT_EQ(result.largest_band_hz, 20);
  // 11.25 um/s.
  EXPECT_EQ(result.vibration_class, "VC-C");
}

TEST(Verdict, SummariesComeFromLogAndComparison) {
  const ScratchFolder folder;
  {
    LogWriter log(folder / "run.lcm");
    write_run(log, 1, 11);
    stillframe_msgs::timing_t timing{};
    timing.run_id = 1;
    timing.source = "plant";
    timing.wall_time_ns = 4'000'000;
    timing.worst_compute_ns = 2500;
    log.write(channels::timing, timing);
  }
  RunLog log = read_run_log(folder / "run.lcm");
  RunSummary run = summarise(log);
  EXPECT_EQ(run.n_samples, 11);
  EXPECT_EQ(run.scene_name, "sample");
  // 10 periods of 1 ms in 4 ms, then by the logger's clock in 20 ms.
  EXPECT_NEAR(run.real_time_factor, 2.5, 1e-12);
  ASSERT_EQ(timing_of(log).size(), 1u);
  EXPECT_NEAR(timing_of(log)[0].worst_compute_us, 2.5, 1e-12);
  log.plant_timing.reset();
  EXPECT_NEAR(summarise(log).real_time_factor, 0.5, 1e-9);

  PredictionError open, closed;
  open.largest_db = 0.05;
  closed.largest_db = 0.3;
  const ReductionCheck reduction{.n_frequencies = 2, .n_below = 2};
  const auto id = summarise(open, closed, reduction, {1, 20, 30}, 10, -50, 0.2);
  EXPECT_EQ(id.n_frequencies, 3);
  EXPECT_EQ(id.highest_hz, 30);
  EXPECT_EQ(id.open_largest_db, 0.05);
  EXPECT_FALSE(id.pass());
}

TEST(Verdict, WritesAFileOrSaysThatItCannot) {
  const ScratchFolder folder;
  write_json(sample_verdict(), folder / "verdict.json");
  std::ifstream file(folder / "verdict.json");
  EXPECT_EQ(json::parse(file), json::parse(to_json(sample_verdict())));
  expect_error<InputError>([&] { write_json(sample_verdict(), folder / "none" / "verdict.json"); },
                           "cannot be written");
}

}  // namespace
}  // namespace stillframe::report

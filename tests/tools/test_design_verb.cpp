#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <numbers>
#include <regex>
#include <sstream>

#include "core/numerics/worst.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class DesignVerb : public Verb {};

TEST_F(DesignVerb, JsonSaysWhatThePageSays) {
  const std::filesystem::path frame = config("scenes/metrology_frame.yaml");
  const Json document = json({"design", frame});
  expect_documented_keys("design", document);
  EXPECT_EQ(document["closed_loop_poles"].size(), 18u);  // 12 of the frame, 6 of the law
  EXPECT_EQ(document["frequencies_hz"].size(), document["noise_m_s2_per_n"].size());
  // Six equal legs: both orders are one matrix, and all poles are on their targets.
  for (const char* order : {"exact_order", "deck_order"}) {
    EXPECT_NEAR(document[order]["lowest"].get<double>(), 1, 1e-9) << order;
    EXPECT_NEAR(document[order]["highest"].get<double>(), 1, 1e-9) << order;
  }
  // 1 Hz, where the law hardly acts, and 50 Hz, where it would hold the frame still, were it not
  // sampled: docs/design_cases.md.
  EXPECT_EQ(document["frequencies_hz"], Json({0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0}));
  const auto at = [&](const char* key, int line) { return document[key][line][0].get<double>(); };
  EXPECT_NEAR(at("closed_singular_values", 1), 1, 0.05);
  EXPECT_NEAR(at("continuous_singular_values", 6), 0.01, 1e-4);  // (5 / 50)^2
  EXPECT_NEAR(20 * std::log10(at("closed_singular_values", 6)), -16.7, 0.05);
  const Json margins = document["margins"];
  EXPECT_EQ(margins["leg_gain"].size(), 6u);
  EXPECT_LT(margins["all_gain"][0].get<double>(), 1);
  EXPECT_GT(margins["all_gain"][1].get<double>(), 1);
  const Json rates = document["stable_rates_hz"].back();
  EXPECT_LT(rates[0].get<double>(), 1000);
  EXPECT_GT(rates[1].get<double>(), 1000);
}

// Roll-off and the lead that makes up for it belong together in every column: at 1 kHz upwards the
// loop that runs tends to its continuous law.
TEST_F(DesignVerb, TheLeadThatMatchesARollOffIsInEveryColumn) {
  std::ifstream file(config("controllers/force_feedback_5khz.yaml"));
  std::string block((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  block.replace(block.find("sample_rate_hz: 5000"), 20, "sample_rate_hz: 20000");
  // delay + 1/2 + 20000 / (2 pi 320)
  block.replace(block.find("lead_samples: 3.99"), 18, "lead_samples: 11.447");
  const Json document = json(
      {"design", config("scenes/metrology_frame.yaml"), "--controller", write("fast.yaml", block)});
  for (int line = 0; line < 6; ++line) {  // 0.5 to 20 Hz
    const double runs = document["closed_singular_values"][line][0],
                 continuous = document["continuous_singular_values"][line][0];
    // What the lead leaves is of second order, (omega T_s)^2 of the roll-off's 10 samples.
    EXPECT_NEAR(20 * std::log10(runs / continuous), 0, 0.1) << line;
  }
}

// In closed form: of a mass m on a leg k that the law acts on, a force moves the frame by
//   1 / (m s^2 + k / (1 + P)),   P = (K_P s + K_I) / (s + w_l),
// and by 1 / (m s^2 + k) without it.
TEST_F(DesignVerb, TheForceColumnHasTheLeadThatMatchesARollOff) {
  const double pi = std::numbers::pi, m = 10, k = 4e5, target = 2 * pi * 5, leak = 2 * pi * 0.05;
  const auto scene = write("scene.yaml", R"(title: 10 kg on a leg
nodes:
  floor: {position: [0, 0, 0]}
  frame: {position: [0, 0, 1]}
masses: [{node: frame, mass: 10}]
elements:
  leg: {type: truss, nodes: [floor, frame], stiffness: 4e5}
supports: [{nodes: [floor, frame], fix: [x, y]}]
prescribed: [{nodes: [floor], move: [z]}]
dofs: [{element: leg}]
inputs: [{name: floor, acceleration: floor, along: z}]
outputs: [{name: frame, acceleration: frame, along: z}]
controller:
  {legs: [leg], target_hz: 5, damping_ratio: 0.7, sample_rate_hz: 20000, delay_samples: 1,
   leak_hz: 0.05, roll_off_hz: 320, lead_samples: 11.447}  # delay + 1/2 + 20000 / (2 pi 320)
)");
  const Json document = json({"design", scene});
  const std::string page = run({"design", scene}).output;
  std::istringstream rest(page.substr(page.find("   Hz  open dB  closed dB  force dB")));
  std::string row;
  std::getline(rest, row);
  for (int line = 0; line < 6; ++line) {
    const double hz = document["frequencies_hz"][line];
    const std::complex<double> s(0, 2 * pi * hz);
    const double X = k / m / (target * target), K_I = 2 * 0.7 * target * X;
    const auto P = ((X - 1) * s + K_I) / (s + leak);
    const double exact = 20 * std::log10(std::abs((m * s * s + k) / (m * s * s + k / (1.0 + P))));
    const double found = 20 * std::log10(document["compliance"][line].get<double>() /
                                         document["passive_compliance"][line].get<double>());
    // Of first order in what a sample is of the roll-off, 0.1: 0.022 dB, and half of that at twice
    // the rate.
    EXPECT_NEAR(found, exact, 0.05) << hz;
    std::getline(rest, row);
    double at = 0, open = 0, closed = 0, force = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf %lf %lf %lf", &at, &open, &closed, &force), 4) << row;
    EXPECT_EQ(at, hz);
    EXPECT_NEAR(force, found, 0.051) << hz;  // of its last digit
  }
}

const char* const scene_of_two_masses = R"(title: 10 kg, and 0.3 kg on top
nodes:
  floor: {position: [0, 0, 0]}
  frame: {position: [0, 0, 1]}
  top: {position: [0, 0, 2]}
masses:
  - {node: frame, mass: 10}
  - {node: top, mass: 0.3}
elements:
  leg: {type: truss, nodes: [floor, frame], stiffness: 4e5, damping: 20}
  rod: {type: truss, nodes: [frame, top], stiffness: 1577831, damping: 0.02752}
supports:
  - {nodes: [floor, frame, top], fix: [x, y]}
prescribed:
  - {nodes: [floor], move: [z]}
dofs:
  - {element: leg}
  - {element: rod}
inputs:
  - {name: floor, acceleration: floor, along: z}
outputs:
  - {name: frame, acceleration: frame, along: z}
controller:
  legs: [leg]
  target_hz: 5
  damping_ratio: DAMPING
  order: exact
  sample_rate_hz: 1000
  delay_samples: 1
  lead_samples: 0
  leak_hz: 0.05
)";

std::string two_masses(const std::string& damping_ratio) {
  std::string text = scene_of_two_masses;
  return text.replace(text.find("DAMPING"), 7, damping_ratio);
}

// The 370.4 Hz of two_masses, damped by 2e-5, stand between 200 and 500 Hz.
TEST_F(DesignVerb, ThePeaksBetweenTheLinesHaveLines) {
  const auto scene = write("scene.yaml", two_masses("0.7"));
  const Json document = json({"design", scene});
  const std::string page = run({"design", scene}).output;
  const auto highest = [&](const std::string& of, double from, double to) -> Json {
    for (const Json& peak : document["peaks"]) {
      const double hz = peak["hz"];
      if (peak["of"] == of && hz > from && hz < to) return peak;
    }
    return {};
  };
  // The frame alone, 4e5 / 10 with a damper of 20: 31.8 Hz and a bit less with 0.3 kg on top.
  const Json open = highest("open", 20, 50), closed = highest("closed", 200, 500);
  ASSERT_FALSE(open.is_null()) << document["peaks"];
  ASSERT_FALSE(closed.is_null()) << document["peaks"];
  EXPECT_NEAR(open["hz"].get<double>(), 31.35, 0.05);
  const double zeta = 20 / (2 * std::sqrt(4e5 * 10.3));
  EXPECT_NEAR(open["singular_value"].get<double>() * 2 * zeta, 1, 0.01);
  EXPECT_NEAR(closed["hz"].get<double>(), 370.4, 0.5);
  const size_t last = document["frequencies_hz"].size() - 1;
  const double beside = std::max(document["closed_singular_values"][last][0].get<double>(),
                                 document["closed_singular_values"][last - 1][0].get<double>());
  EXPECT_GT(closed["singular_value"].get<double>(), 10 * beside);
  char row[40];
  std::snprintf(row, sizeof row, "%.1f", 20 * std::log10(closed["singular_value"].get<double>()));
  const size_t at = page.find(" 370.", page.find("Floor to frame"));
  ASSERT_NE(at, std::string::npos) << page;
  EXPECT_NE(page.find(row, at), std::string::npos) << page;
  EXPECT_NE(page.find("  closed\n", at), std::string::npos) << page;
}

// 365 Hz, damped by 2e-5.
TEST_F(DesignVerb, ANarrowResonanceIsInTheMargin) {
  const Json document = json({"design", write("scene.yaml", two_masses("0.7"))});
  const double up = document["margins"]["leg_gain"][0][1], disk = document["margins"]["all_disk"];
  EXPECT_LT(up, 1.2);
  EXPECT_LE(disk, 2 * (up - 1) / (up + 1) * (1 + 1e-5));  // gains are found to 1e-6
  EXPECT_NEAR(document["margins"]["all_disk_hz"].get<double>(), 370, 2);
  EXPECT_EQ(document["margins"]["leg_disk"][0], document["margins"]["all_disk"]);
  EXPECT_EQ(document["frequencies_hz"].back(), 500.0);
}

// One output: nothing of it reaches another.
// "none" would say that a gain must not go down at all.
TEST_F(DesignVerb, AGainThatMayGoToNothingHasNoLimit) {
  const std::filesystem::path frame = config("scenes/frame_under_gravity.yaml");
  ASSERT_EQ(json({"design", frame})["margins"]["leg_gain"][0][0], 0.0);
  const std::string page = run({"design", frame}).output;
  const size_t row = page.find("leg_1t", page.find("gain down"));
  ASSERT_NE(row, std::string::npos) << page;
  EXPECT_EQ(page.substr(row, page.find('\n', row) - row).find("no limit"),
            std::string("leg_1t        ").size())
      << page;
}

TEST_F(DesignVerb, ACrosstalkOfNothingIsNoNumber) {
  const auto scene = write("scene.yaml", two_masses("0.7"));
  const Said said = run({"design", scene});
  EXPECT_NE(said.output.find("crosstalk dB"), std::string::npos) << said.output;
  EXPECT_EQ(said.output.find("-inf"), std::string::npos) << said.output;
  EXPECT_TRUE(json({"design", scene})["crosstalk_db"][0].is_null());
}

// One leg: the orders of the matrices are one, also where damping parts the poles.
TEST_F(DesignVerb, OrdersThatCoincideAreNotWarnedOf) {
  const Json document = json({"design", write("scene.yaml", two_masses("1.2"))});
  for (const std::string warning : document["warnings"]) {
    EXPECT_EQ(warning.find("order of the matrices"), std::string::npos) << warning;
  }
  for (const char* order : {"exact_order", "deck_order"}) {
    EXPECT_NEAR(document[order]["lowest"].get<double>(), 1, 1e-9) << order;
    EXPECT_NEAR(document[order]["highest"].get<double>(), 1, 1e-9) << order;
  }
}

// A spring beside the leg holds the frame where the integrator has taken the leg's away.
TEST_F(DesignVerb, NothingDriftsThatASpringHolds) {
  std::string text = two_masses("0.7");
  text.replace(text.find("leak_hz: 0.05"), 13, "leak_hz: 0");
  const auto has = [](const Said& said, const std::string& words) {
    return (said.output + said.error).find(words) != std::string::npos;
  };
  const Said free = run({"design", write("free.yaml", text)});
  EXPECT_EQ(free.exit_code, 3);
  EXPECT_TRUE(has(free, "drift for ever")) << free.output << free.error;
  text.insert(text.find("supports:"),
              "  spring: {type: truss, nodes: [floor, frame], stiffness: 1e5, damping: 5}\n");
  const Said held = run({"design", write("held.yaml", text)});
  EXPECT_EQ(held.exit_code, 0) << held.error;
  EXPECT_FALSE(has(held, "drift for ever")) << held.output;
  // (4e5 + 1e5) / 1e5
  EXPECT_TRUE(has(held, "gives way up to 5 times as far")) << held.output;
}

// 10 kg on a leg of 4e5 N/m along x that the law acts on, beside a spring that holds it there, and
// on one of 3e5 N/m along y, sqrt(3e4) rad/s = 27.57 Hz, that it does not.
TEST_F(DesignVerb, AMotionThatTheLawDoesNotReachIsNamedWithWhatMendsIt) {
  const std::string scene = R"(title: A mass on two legs, one of which is controlled
nodes:
  tx: {position: [-0.1, 0, 0]}
  ty: {position: [0, -0.1, 0]}
  sx: {position: [0.1, 0, 0]}
  mass: {position: [0, 0, 0]}
masses: [{node: mass, mass: 10}]
elements:
  leg_x: {type: truss, nodes: [tx, mass], stiffness: 4e5, damping: 20}
  spring: {type: truss, nodes: [sx, mass], stiffness: 1e5, damping: 20}
  leg_y: {type: truss, nodes: [ty, mass], stiffness: 3e5DAMPED}
supports: [{nodes: [tx, ty, sx, mass], fix: [z]}]
prescribed: [{nodes: [tx, ty, sx], move: [x, y]}]
dofs: [{element: leg_x}, {element: leg_y}]
inputs: [{name: floor, acceleration: tx, along: x}]
outputs: [{name: x, acceleration: mass, along: x}]
controller: {legs: [leg_x], target_hz: 5, sample_rate_hz: 1000, damping_ratio: 0.7,
  delay_samples: 1, lead_samples: 1.5, leak_hz: LEAK}
)";
  const auto said = [&](const std::string& leak, const std::string& damped) {
    std::string text = scene;
    text.replace(text.find("DAMPED"), 6, damped);
    text.replace(text.find("LEAK"), 4, leak);
    return run({"design", write("scene.yaml", text)});
  };
  for (const char* leak : {"0", "0.05"}) {
    const Said undamped = said(leak, "");
    EXPECT_EQ(undamped.exit_code, 3);
    for (const std::string& text : {undamped.output, undamped.error}) {
      EXPECT_NE(text.find("he law does not reach what moves at 27.57 Hz"), std::string::npos)
          << text;
      for (const char* wrong : {"drift for ever", "at fault", "design the gains anew",
                                "What mends it", "do not settle"}) {
        EXPECT_EQ(text.find(wrong), std::string::npos) << wrong << " in " << text;
      }
    }
    // What the refusal asks for does mend it.
    EXPECT_EQ(said(leak, ", damping: 20").exit_code, 0) << leak;
  }
}

// A law takes the stiffness of its legs away, and leaves the frame on a spring beside them: the
// pole at -1.68 +- 101.9j of the law, where the frame moves more at whatever rate.
TEST_F(DesignVerb, WhatTheLawDoesIsNoPriceOfSampling) {
  std::string text = two_masses("0.7");
  text.insert(text.find("supports:"),
              "  spring: {type: truss, nodes: [floor, frame], stiffness: 1e5, damping: 5}\n");
  const Json document = json({"design", write("scene.yaml", text)});
  const std::string words = " Hz the controlled frame moves up to ";
  int of_law = 0, of_sampling = 0;
  for (const std::string warning : document["warnings"]) {
    if (warning.find(words) == std::string::npos) continue;
    double from = 0, to = 0;
    ASSERT_EQ(std::sscanf(warning.c_str(), "between %lf and %lf", &from, &to), 2) << warning;
    if (warning.find("the price of sampling") != std::string::npos) {
      ++of_sampling;
      EXPECT_GT(from, 100) << warning;  // 1.5 samples are a radian at 106 Hz
    } else {
      ++of_law;
      EXPECT_NE(warning.find("most of that without sampling too: the law leaves a motion at 16.21 "
                             "Hz to a damping ratio of 0.016"),
                std::string::npos)
          << warning;
      EXPECT_LT(to, 35.6) << warning;  // the passive resonance, sqrt(5e5 / 10) rad/s
    }
  }
  EXPECT_EQ(of_law, 1);
  EXPECT_EQ(of_sampling, 1);
  // The frame on its spring, and what stands on it.
  EXPECT_NE(document["warnings"].dump().find(
                "1 leg(s) act on as many of the frame's 2 motions; hardly damped by the law, "
                "without sampling: 16.21 Hz (damping ratio 0.016), 370.4 Hz"),
            std::string::npos)
      << document["warnings"];
}

// With the weight on the legs, as `modes` counts it: 13.85 Hz, and 13.91 Hz without it.
TEST_F(DesignVerb, TheSlowestModeIsThatOfModes) {
  const std::filesystem::path scene = config("scenes/frame_under_gravity.yaml");
  std::ifstream file(config("controllers/force_feedback_5hz.yaml"));
  std::string block((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  block.replace(block.find("target_hz: 5"), 12, "target_hz: 20");
  block.replace(block.find("leak_hz: 0.05"), 13, "leak_hz: 10");
  char slowest[32];
  std::snprintf(slowest, sizeof slowest, "%.4g",
                json({"modes", scene})["natural_frequencies_hz"][0].get<double>());
  const Said page = run({"design", scene, "--controller", write("high.yaml", block)});
  EXPECT_NE(page.output.find("above the slowest mode on the legs, " + std::string(slowest) + " Hz"),
            std::string::npos)
      << page.output;
}

TEST_F(DesignVerb, InstrumentsAreNotCalledSampling) {
  // Where little of the floor is left it is a note.
  const std::string slow =
      json({"design", config("scenes/frame_slow_actuators.yaml")})["notes"].dump();
  EXPECT_NE(slow.find("the price of sampling and of the instruments; a higher rate moves up what "
                      "is of sampling"),
            std::string::npos)
      << slow;
  const std::string ideal =
      json({"design", config("scenes/metrology_frame.yaml")})["warnings"].dump();
  EXPECT_NE(ideal.find("the price of sampling; a higher rate"), std::string::npos) << ideal;
}

// Modes of 13.9 to 49 Hz: 20 Hz softens the last one and would stiffen the first two.
TEST_F(DesignVerb, TargetsOfTheirOwnAreComparedWithTheirOwnModes) {
  std::ifstream file(config("controllers/force_feedback_5hz.yaml"));
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto warnings = [&](const std::string& targets) {
    std::string block = text;
    block.replace(block.find("target_hz: 5"), 12, "target_hz: " + targets);
    return json({"design", config("scenes/metrology_frame.yaml"), "--controller",
                 write("targets.yaml", block)})["warnings"]
        .dump();
  };
  const std::string soft = warnings("[5, 5, 5, 5, 5, 20]"),
                    stiff = warnings("[20, 20, 5, 5, 5, 5]");
  EXPECT_EQ(soft.find("stiffens it"), std::string::npos) << soft;
  EXPECT_NE(stiff.find("the target 20 Hz is above virtual mode 1, 13.91 Hz"), std::string::npos)
      << stiff;
}

TEST_F(DesignVerb, WhatIsRecommendedIsNotWarnedOf) {
  for (const char* scene : {"metrology_frame", "frame_unequal_legs", "frame_slow_actuators"}) {
    const std::filesystem::path path = config(std::string("scenes/") + scene + ".yaml");
    const std::filesystem::path controller = config("controllers/force_feedback_5hz.yaml");
    const Json found = json({"design", path, "--controller", controller})["recommended"];
    ASSERT_FALSE(found.is_null()) << scene;
    std::ifstream file(controller);
    std::string block, line;
    while (std::getline(file, line)) {
      if (line.find("sample_rate_hz") == 0 || line.find("lead_samples") == 0) continue;
      block += line + "\n";
    }
    block += "sample_rate_hz: " + found["sample_rate_hz"].dump() +
             "\nlead_samples: " + found["lead_samples"].dump() + "\n";
    if (!found["roll_off_hz"].is_null())
      block += "roll_off_hz: " + found["roll_off_hz"].dump() + "\n";
    const Json there = json({"design", path, "--controller", write("recommended.yaml", block)});
    // What the page says of every setting, it has said with its recommendation.
    for (const std::string warning : there["warnings"]) {
      const auto& told = found["warnings"];
      const bool known = std::find(told.begin(), told.end(), warning) != told.end();
      for (const char* words : {"thin margin", "one sample late", "more than the passive",
                                "unstable again", "a twentieth"}) {
        EXPECT_TRUE(known || warning.find(words) == std::string::npos) << scene << ": " << warning;
      }
    }
  }
}

// A lead that was matched to five times the rate: the first thing that mends it is the one that is
// matched to this one, delay + 1/2 + f_s / (2 pi f_r).
TEST_F(DesignVerb, ALeadOfAnotherRateIsMatchedAnew) {
  std::ifstream file(config("controllers/lens_frame_5khz.yaml"));
  std::string block((std::istreambuf_iterator<char>(file)), {});
  block.replace(block.find("sample_rate_hz: 5000"), 20, "sample_rate_hz: 1000");
  const std::vector<std::string> design{"design", config("scenes/lens_frame.yaml"), "--controller",
                                        write("slow.yaml", block)};
  const Said refused = run({design.begin(), design.end()});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.error.find("What mends it: lead_samples: 1.997"), std::string::npos)
      << refused.error;
  block.replace(block.find("lead_samples: 3.99"), 18, "lead_samples: 1.997");
  write("slow.yaml", block);
  EXPECT_EQ(run({design.begin(), design.end()}).exit_code, 0);
}

// What a feed-forward aims at is where everything that judges the loop begins.
TEST_F(DesignVerb, AFeedForwardsOwnTargetIsTheLoops) {
  const std::filesystem::path scene = config("scenes/metrology_frame.yaml");
  std::ifstream file(config("controllers/feed_forward_1khz.yaml"));
  std::string block((std::istreambuf_iterator<char>(file)), {});
  block.replace(block.find("feed_forward: {}"), 16, "feed_forward: {target_hz: 2}");
  const std::filesystem::path controller = write("low.yaml", block);
  EXPECT_EQ(json({"design", scene, "--controller", controller})["feed_forward"]["corner_hz"], 0.2);
  const Json spread =
      json({"robustness", scene, "--controller", controller, "--uncertainty",
            config("uncertainty/piezo_frame.yaml"), "--samples", "1", "--no-search"});
  EXPECT_EQ(spread["frequencies_hz"][0], 0.04);
  const Json run = json({"run", scene, "--controller", controller, "--mode", "single_process",
                         "--duration", "2", "--out", write("run", "").string() + "_of_it"});
  EXPECT_EQ(run["isolates_above_hz"], 4);
}

/// The frame as one would ship it. Each of its properties is warned of where it is taken away.
TEST_F(DesignVerb, TheLensFrameIsWarnedOfNothing) {
  const std::filesystem::path path = config("scenes/lens_frame.yaml");
  const Json page = json({"design", path});
  EXPECT_EQ(page["warnings"], Json::array());
  EXPECT_EQ(page["notes"].size(), 2u);
  EXPECT_GE(page["margins"]["all_disk"], 0.5);
  const auto warned_of = [&](const std::string& text, const std::string& controller,
                             const std::string& words) {
    const Json there = json({"design", write("scene.yaml", text), "--controller", controller});
    bool found = false;
    for (const std::string warning : there["warnings"]) {
      found = found || warning.find(words) != std::string::npos;
    }
    EXPECT_TRUE(found) << words << ": " << there["warnings"];
  };
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto without = [&](const std::string& line) {
    std::string changed = text;
    const auto at = changed.find(line);
    EXPECT_NE(at, std::string::npos) << line;
    if (at != std::string::npos) changed.erase(at, changed.find('\n', at) - at);
    return changed;
  };
  const std::string own = config("controllers/lens_frame_5khz.yaml");
  for (const char* line : {"controller:", "floor: ../"}) text = without(line);
  warned_of(without("  report_age_samples: 0"), own, "one sample late");
  warned_of(text, config("controllers/force_feedback_5khz.yaml"), "at standstill");
  warned_of(text, config("controllers/feed_forward_1khz.yaml"), "more than the passive");
  warned_of(text, config("controllers/force_feedback_5hz.yaml"), "thin margin");
}

// T is held against what the loop is for: a remedy that gives isolation away, a feed-forward whose
// aim is out of reach, and what it was to keep beyond.
TEST_F(DesignVerb, WhatMovesMoreThanIsAimedAtIsWarnedOf) {
  std::ifstream file(config("controllers/feed_forward_1khz.yaml"));
  const std::string block((std::istreambuf_iterator<char>(file)), {});
  const auto warnings = [&](const std::string& feed_forward) {
    std::string changed = block;
    changed.replace(changed.find("feed_forward: {}"), 16, feed_forward);
    return json({"design", config("scenes/metrology_frame.yaml"), "--controller",
                 write("changed.yaml", changed)})["warnings"]
        .dump();
  };
  const std::string aimed = "dB more than what is aimed at", beyond = "more than the at_most_db";
  EXPECT_EQ(warnings("feed_forward: {}").find(aimed), std::string::npos);
  EXPECT_EQ(warnings("feed_forward: {}").find(beyond), std::string::npos);
  EXPECT_NE(warnings("").find(aimed), std::string::npos);
  const std::string low = warnings("feed_forward: {target_hz: 0.5}");
  EXPECT_NE(low.find(aimed + ", the target 0.5 Hz"), std::string::npos) << low;
  EXPECT_NE(low.find(beyond), std::string::npos) << low;
  EXPECT_NE(
      warnings("feed_forward: {target_hz: 200}").find("the target 200 Hz is above the slowest"),
      std::string::npos);
}

/// A body of 120 kg on two legs and a guide, and a bob of 2 kg on a rod at its top, on a hinge.
std::string body_and_bob(const std::string& bob, const std::string& stiffness,
                         const std::string& target, const std::string& leak) {
  return R"(title: A frame with a bob
planar: true
gravity: [0, -9.81]
nodes:
  body: {position: [0, 0.5]}
  left: {position: [-0.4, 0.4]}
  right: {position: [0.4, 0.4]}
  floor_l: {position: [-0.4, 0]}
  floor_r: {position: [0.4, 0]}
  wall: {position: [0.9, 0.4]}
  hook: {position: [0, 0.9]}
  pivot: {position: [0, 0.9]}
  bob: {position: [0, )" +
         bob + R"(]}
masses:
  - {node: body, mass: 120, inertia: 9}
  - {node: bob, mass: 2}
elements:
  arm_l: {type: rigid_beam, nodes: [body, left]}
  arm_r: {type: rigid_beam, nodes: [body, right]}
  arm_h: {type: rigid_beam, nodes: [body, hook]}
  leg_l: {type: truss, nodes: [floor_l, left], stiffness: 8e5, damping: 200}
  leg_r: {type: truss, nodes: [floor_r, right], stiffness: 8e5, damping: 200}
  guide: {type: truss, nodes: [wall, right], stiffness: 8e5, damping: 200}
  bearing: {type: hinge, nodes: [hook, pivot], stiffness: )" +
         stiffness + R"(, damping: 0.1}
  rod: {type: rigid_beam, nodes: [pivot, bob]}
prescribed:
  - {nodes: [floor_l, floor_r, wall], move: [x, y]}
dofs: [{element: leg_l}, {element: leg_r}, {element: guide}, {element: bearing}]
inputs:
  - {name: floor_l, acceleration: floor_l, along: y}
  - {name: floor_r, acceleration: floor_r, along: y}
  - {name: wall, acceleration: wall, along: x}
outputs:
  - {name: body_x, acceleration: body, along: x}
  - {name: body_y, acceleration: body, along: y}
controller:
  {legs: [leg_l, leg_r, guide], target_hz: )" +
         target + R"(, damping_ratio: 0.7, sample_rate_hz: 1000,
   delay_samples: 1, lead_samples: 1.5, leak_hz: )" +
         leak + "}\n";
}

// A light part that leans on what is no leg does not lean on the law: with it in the sum the leak
// that is named was several times the one that holds. The bob stands on its rod, held by 20 against
// the 5.9 N m/rad of its weight.
TEST_F(DesignVerb, TheLeakThatHoldsTheWeightIsTheOneNamed) {
  // The second has a roll-off with the lead that matches it: delay + 1/2 + 1000 / (2 pi 40).
  for (const char* lead : {"lead_samples: 1.5", "lead_samples: 5.479, roll_off_hz: 40"}) {
    const auto said = [&](double leak) {
      std::string text = body_and_bob("1.2", "20", "1", std::to_string(leak));
      text.replace(text.find("lead_samples: 1.5"), 17, lead);
      return run({"design", write("scene.yaml", text)});
    };
    const std::string words = "a leak alone holds the frame from about ";
    const std::string page = said(3).output;
    const size_t at = page.find(words);
    ASSERT_NE(at, std::string::npos) << page;
    const double named = std::stod(page.substr(at + words.size()));
    // Two digits are shown, and sampling moves it a little.
    EXPECT_EQ(said(1.15 * named).exit_code, 0) << named << "\n" << page;
    EXPECT_EQ(said(0.85 * named).exit_code, 3) << named << "\n" << page;
    // Nor is more of it always better.
    const size_t end = page.find(" Hz to ", at);
    ASSERT_NE(end, std::string::npos) << page;
    const double most = std::stod(page.substr(end + 7));
    EXPECT_EQ(said(0.95 * most).exit_code, 0) << most << "\n" << page;
    EXPECT_EQ(said(1.15 * most).exit_code, 3) << most << "\n" << page;
  }
}

// A target of 0.5 Hz leaves less than a third of what the weight takes.
TEST_F(DesignVerb, WhereTheWeightTakesAllNoLeakIsNamed) {
  for (const char* leak : {"0.1", "1.6", "10"}) {
    const Said said = run({"design", write("scene.yaml", body_and_bob("1.2", "20", "0.5", leak))});
    EXPECT_EQ(said.exit_code, 3) << leak;
    EXPECT_NE(said.output.find("no leak alone holds the frame; a target above about 0.89 Hz"),
              std::string::npos)
        << said.output;
  }
}

// Under its weight the frame needs its leak, and no roll-off and no lead alone helps. What the page
// says does so does.
TEST_F(DesignVerb, WhatWidensAThinMarginDoes) {
  std::string text = body_and_bob("0.6", "0.01", "2", "0.7");
  const auto scene = write("scene.yaml", text);
  const std::string page = run({"design", scene}).output;
  const double before = json({"design", scene})["margins"]["all_disk"];
  std::smatch said;
  ASSERT_TRUE(
      std::regex_search(page, said, std::regex("; of what was tried, (.*) makes it ([0-9.]+)\n")))
      << page;
  const double promised = std::stod(said[2]);
  EXPECT_GT(promised, 1.1 * before);
  const std::string settings = said[1];
  const std::regex setting("([a-z_]+): ([0-9.]+)");
  for (std::sregex_iterator it(settings.begin(), settings.end(), setting), end; it != end; ++it) {
    const std::regex own((*it)[1].str() + ": [0-9.]+");
    if (std::regex_search(text, own)) {
      text = std::regex_replace(text, own, it->str());
    } else {
      text.insert(text.rfind('}'), ", " + it->str());
    }
  }
  const Json changed = json({"design", write("changed.yaml", text)});
  // Two digits are shown, of settings of three.
  EXPECT_NEAR(changed["margins"]["all_disk"].get<double>(), promised, 0.01) << text;
  // Nor does the delay stand in the way of a rate.
  EXPECT_EQ(page.find("with this delay"), std::string::npos) << page;
  EXPECT_NE(page.find("no rate up to 100 kHz can be recommended: at that rate, with any roll-off "
                      "that was tried, the disk margin is "),
            std::string::npos)
      << page;
  EXPECT_NE(page.find("; nor without delay\n"), std::string::npos) << page;
}

// The guide lies along x.
TEST_F(DesignVerb, ALegThatNoInputShakesIsNamed) {
  std::string text = body_and_bob("0.6", "0.01", "4", "1");
  const std::string words = "no input moves the floor along ";
  const std::string all = run({"design", write("scene.yaml", text)}).output;
  EXPECT_EQ(all.find(words), std::string::npos) << all;
  const std::string input = "acceleration: wall, along: x";
  text.replace(text.find(input), input.size(), "acceleration: wall, along: y");
  const std::string without = run({"design", write("scene.yaml", text)}).output;
  EXPECT_NE(without.find(words + "guide:"), std::string::npos) << without;
}

// As many outputs as inputs are no pairs by that alone.
TEST_F(DesignVerb, CrosstalkIsOfOutputsThatBelongToInputs) {
  std::ifstream file(config("scenes/metrology_frame.yaml"));
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::string law = "../controllers/force_feedback_5hz.yaml";
  text.replace(text.find(law), law.size(), config("controllers/force_feedback_5hz.yaml").string());
  EXPECT_TRUE(json({"design", write("scene.yaml", text)})["crosstalk_db"][0].is_number());
  const size_t first = text.find("  - {name:", text.find("\noutputs:")),
               second = text.find("  - {name:", first + 1), third = text.find("\n", second) + 1;
  text = text.substr(0, first) + text.substr(second, third - second) +
         text.substr(first, second - first) + text.substr(third);
  const auto swapped = write("swapped.yaml", text);
  EXPECT_TRUE(json({"design", swapped})["crosstalk_db"][0].is_null());
  EXPECT_EQ(run({"design", swapped}).output.find("crosstalk"), std::string::npos);
}

TEST_F(DesignVerb, ADofWithoutMassIsNamedWithWhatGivesItSome) {
  std::string text = two_masses("0.7");
  text.replace(text.find("  - {node: top, mass: 0.3}\n"), 27, "");
  expect_refused({"design", write("scene.yaml", text)}, 3, "dof e(rod) moves no mass");
  expect_refused({"design", write("scene.yaml", text)}, 3, "inertia_per_length");
}

TEST_F(DesignVerb, SaysWhatARunByTheClockAsksFor) {
  const std::string words = "force_limit_n is not given";
  std::string text = two_masses("0.7");
  EXPECT_NE(run({"design", write("scene.yaml", text)}).output.find(words), std::string::npos);
  text += "  force_limit_n: 100\n";
  EXPECT_EQ(run({"design", write("scene.yaml", text)}).output.find(words), std::string::npos);
}

// The gains are exact, and a leak is what is missing.
TEST_F(DesignVerb, ALeakIsNamedWhereItMends) {
  const Said found = run({"design", config("scenes/frame_under_gravity.yaml"), "--controller",
                          config("controllers/force_feedback_5hz.yaml")});
  EXPECT_EQ(found.exit_code, 3);
  EXPECT_NE(found.error.find("What mends it: leak_hz: "), std::string::npos) << found.error;
  EXPECT_EQ(found.error.find("order"), std::string::npos) << found.error;
}

TEST_F(DesignVerb, UnequalLegsAreWarnedOfTheDecksOrder) {
  const Said page = run({"design", config("scenes/frame_unequal_legs.yaml")});
  EXPECT_EQ(page.exit_code, 0) << page.error;
  EXPECT_NE(
      page.output.find("the deck's order of the matrices (M^-1 K in place of K M^-1) would be "
                       "unstable here (largest real part +8.4 1/s); the exact order, which is "
                       "used, is not"),
      std::string::npos)
      << page.output;
}

TEST_F(DesignVerb, SaysWhichInstrumentsItLeavesOut) {
  const std::filesystem::path frame = config("scenes/metrology_frame.yaml");
  std::ifstream file(frame);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto page = [&](const std::string& name, const std::string& instruments) {
    const Said said = run({"design", write(name, text + "\ninstruments: {" + instruments + "}\n"),
                           "--controller", config("controllers/force_feedback_5hz.yaml")});
    EXPECT_EQ(said.exit_code, 0) << said.error;
    return said.output;
  };
  const std::string words = "the analysis leaves them out: ";
  EXPECT_EQ(page("plain.yaml", "actuator_lag_hz: 300").find(words), std::string::npos);
  EXPECT_NE(
      page("loop.yaml", "hysteresis: {width: 0.1, swing_n: 100}").find(words + "hysteresis\n"),
      std::string::npos);
  EXPECT_NE(page("all.yaml",
                 "hysteresis: {width: 0.1, swing_n: 100}, force_rate_limit_n_per_s: 1e4, "
                 "force_sensors: {offset_n: 1}")
                .find(words + "hysteresis, force_rate_limit_n_per_s, force_sensors\n"),
            std::string::npos);
}

TEST_F(DesignVerb, TakesTheGainsOfAnotherScene) {
  const std::filesystem::path rigid = config("scenes/metrology_frame.yaml"),
                              flexible = config("scenes/frame_flexible.yaml");
  const Json own = json({"design", flexible}),
             other = json({"design", flexible, "--design-scene", rigid}),
             reference = json(
                 {"design", rigid, "--controller", config("controllers/force_feedback_5khz.yaml")});
  // Legs whose elongations leave the frame unstrained have the gains of the rigid frame (least
  // strain energy); its numbers are rounded in another order.
  const auto difference = [](const Json& a, const Json& b) {
    double worst = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      for (size_t j = 0; j < a.size(); ++j) {
        worst = worst_of(worst, std::abs(a[i][j].get<double>() - b[i][j].get<double>()));
      }
    }
    return worst;
  };
  EXPECT_LT(difference(own["K_P"], other["K_P"]),
            1e-3);  // of some 40; nodes are rounded in the scene
  EXPECT_EQ(other["order"], reference["order"]);
  EXPECT_NE(own["closed_loop_poles"].size(), reference["closed_loop_poles"].size());
}

TEST_F(DesignVerb, AModelWithoutTheLegsIsRefusedByName) {
  const Said found = run({"design", config("scenes/metrology_frame.yaml"), "--design-scene",
                          config("scenes/cart.yaml")});
  EXPECT_EQ(found.exit_code, 2);
  EXPECT_NE(found.error.find("has no elastic element 'leg_1t'"), std::string::npos) << found.error;
}

TEST_F(DesignVerb, AnUnstableLoopIsPrintedAndRefusedWithoutAFile) {
  const Said found =
      run({"design", config("scenes/frame_under_gravity.yaml"), "--controller",
           config("controllers/force_feedback_5hz.yaml"), "--out", folder_ / "g.yaml"});
  EXPECT_EQ(found.exit_code, 3);
  EXPECT_NE(found.output.find("the sampled loop is not stable"), std::string::npos) << found.output;
  EXPECT_NE(found.output.find("the weight and preload on the legs take up to"), std::string::npos)
      << found.output;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "g.yaml"));
}

TEST_F(DesignVerb, ALoopThatDecaysTooSlowlyToTellIsNotCalledUnstable) {
  const auto slow =
      write("slow.yaml",
            "legs: [leg_1t, leg_1v, leg_2t, leg_2v, leg_3t, leg_3v]\ntarget_hz: 5\n"
            "damping_ratio: 0.7\nsample_rate_hz: 1e6\ndelay_samples: 1\nleak_hz: 1e-4\n");
  const Said found = run({"design", config("scenes/metrology_frame.yaml"), "--controller", slow});
  EXPECT_EQ(found.exit_code, 3);
  EXPECT_NE(found.output.find("whether the sampled closed loop is stable cannot be told"),
            std::string::npos)
      << found.output;
  EXPECT_EQ(found.output.find("at fault"), std::string::npos) << found.output;
}

}  // namespace
}  // namespace stillframe::test

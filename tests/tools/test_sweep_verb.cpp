#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class SweepVerb : public Verb {
 protected:
  /// A mass on two legs, its controller block in the scene or in a file of its own.
  std::string leg_scene(const std::string& target = "5", const std::string& mass = "400",
                        const std::string& stiffness = "4e5") const {
    std::string legs;
    for (const std::string leg : {"leg_a", "leg_b"}) {
      legs += "  " + leg + ": {type: truss, nodes: [floor, mass], stiffness: " + stiffness + "}\n";
    }
    return "title: Two legs\nnodes:\n  floor: {position: [0, 0, 0]}\n  mass: {position: [0, 0, "
           "1]}\n"
           "masses:\n  - {node: mass, mass: " +
           mass + "}\nelements:\n" + legs +
           "supports:\n  - {nodes: [mass], fix: [x, y]}\n  - {nodes: [floor], fix: [x, y]}\n"
           "prescribed:\n  - {nodes: [floor], move: [z]}\ndofs:\n  - {element: leg_a}\n"
           "inputs:\n  - {name: floor, acceleration: floor, along: z}\n"
           "outputs:\n  - {name: mass, acceleration: mass, along: z}\n"
           "controller:\n  legs: [leg_a, leg_b]\n  target_hz: " +
           target +
           "\n  damping_ratio: 0.7\n  sample_rate_hz: 1000\n  delay_samples: 1\n  leak_hz: 0.05\n"
           "  lead_samples: 1\n";
  }
  std::string number(double value) const {
    std::ostringstream text;
    text.precision(6);
    text << value;
    return text.str();
  }
};

/// A row of a sweep is what `design` says of the scene with these values written into it.
TEST_F(SweepVerb, ARowIsTheDesignOfTheSceneWithTheseValues) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> target(2, 20), mass(200, 900), stiffness(2e5, 9e5);
  const auto scene = write("scene.yaml", leg_scene());
  for (int trial = 0; trial < 4; ++trial) {
    const std::string t = number(target(random)), m = number(mass(random)),
                      k = number(stiffness(random));
    const Json swept =
        json({"sweep", scene, "--set", "controller.target_hz=" + t, "--set",
              "masses.mass.mass=" + m, "--set", "elements.leg_*.stiffness=" + k, "--at", "10,50"});
    expect_documented_keys("sweep", swept);
    ASSERT_EQ(swept["rows"].size(), 1u);
    const Json& row = swept["rows"][0];
    const Json design = json({"design", write("by_hand.yaml", leg_scene(t, m, k))});
    EXPECT_EQ(row["set"]["controller.target_hz"], t);
    EXPECT_EQ(row["spectral_radius"], design["spectral_radius"]);
    EXPECT_EQ(row["disk_margin"], design["margins"]["all_disk"]);
    EXPECT_EQ(row["disk_margin_hz"], design["margins"]["all_disk_hz"]);
    EXPECT_EQ(row["stable"], true);
    EXPECT_TRUE(row["failure"].is_null());
    // Where the page has the frequency too: to the rounding of another order of sums.
    for (const Json& line : row["transmission"]) {
      const auto& hz = design["frequencies_hz"];
      const auto at = std::find(hz.begin(), hz.end(), line["hz"]) - hz.begin();
      ASSERT_LT(static_cast<size_t>(at), hz.size()) << line;
      const double T = design["closed_singular_values"][static_cast<size_t>(at)][0];
      EXPECT_NEAR(line["singular_value"], T, 1e-9 * T);
      EXPECT_LE(line["singular_value"], row["peak"]);
    }
  }
}

TEST_F(SweepVerb, EveryCombinationInOrderAndTheEndsOfARangeAreExact) {
  const auto scene = write("scene.yaml", leg_scene());
  const Json swept = json({"sweep", scene, "--set", "controller.target_hz=2:20:3:log", "--set",
                           "masses.1.mass=300:400:2"});
  EXPECT_EQ(swept["n_points"], 6);
  std::vector<std::string> found;
  for (const Json& row : swept["rows"]) {
    found.push_back(row["set"]["controller.target_hz"].get<std::string>() + " " +
                    row["set"]["masses.1.mass"].get<std::string>());
  }
  const std::vector<std::string> ends{found[0], found[1], found[4], found[5]};
  EXPECT_EQ(ends, (std::vector<std::string>{"2 300", "2 400", "20 300", "20 400"}));
  // The square root of 2 times 20, to the last digit but the rounding of pow.
  EXPECT_NEAR(std::stod(found[2]), std::sqrt(40.0), 1e-14 * std::sqrt(40.0));
}

/// The recipe of the help: shards by themselves, side by side, put together by cat.
TEST_F(SweepVerb, ShardsPutTogetherAreTheWholeAndNothingIsComputedAgain) {
  const auto scene = write("scene.yaml", leg_scene());
  const std::vector<std::string> call{
      "sweep", scene.string(), "--set", "controller.target_hz=2:12:11", "--at", "20"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = call;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const Json whole = json(call);
  std::string parts;
  for (const std::string shard : {"1", "2", "3"}) {
    const auto part = scene.parent_path() / ("part_" + shard + ".jsonl");
    EXPECT_EQ(run(with({"--shard", shard + "/3", "--out", part.string()})).exit_code, 0);
    parts += bytes_of(part);
  }
  EXPECT_EQ(std::count(parts.begin(), parts.end(), '\n'), 11);
  const auto all = write("all.jsonl", parts);
  EXPECT_EQ(json(with({"--out", all.string()})), whole);
  EXPECT_EQ(bytes_of(all), parts) << "every row was there";
  EXPECT_EQ(json(with({"--jobs", "1"})), whole);
}

TEST_F(SweepVerb, GoesOnWhereItWasKilledAndTakesNothingOfAnotherQuestion) {
  const auto scene = write("scene.yaml", leg_scene());
  const auto out = scene.parent_path() / "rows.jsonl";
  const std::vector<std::string> call{
      "sweep", scene.string(), "--set",  "controller.target_hz=2:6:5",
      "--out", out.string(),   "--jobs", "1"};
  const Json whole = json(call);
  const std::string rows = bytes_of(out);
  // Of a program that was killed in its fourth line.
  const size_t third = rows.find('\n', rows.find('\n', rows.find('\n') + 1) + 1);
  write("rows.jsonl", rows.substr(0, third + 20));
  EXPECT_EQ(json(call), whole);
  EXPECT_EQ(bytes_of(out), rows);
  // Another figure, or another value of a key, is a row that nobody wrote; nothing is added to it.
  for (const std::string key : {"peak", "stable", "failure"}) {
    std::string changed = rows;
    const size_t at = changed.find("\"" + key + "\":", changed.find('\n')) + key.size() + 3;
    changed.replace(at, changed.find(',', at) - at, key == "failure" ? "7" : "null");
    write("rows.jsonl", changed);
    expect_refused(call, 2, "rows.jsonl:2: found a row that is not as it was written");
    EXPECT_EQ(bytes_of(out), changed);
  }
  write("rows.jsonl", rows);
  // Another mass is another scene, other frequencies are another question.
  write("scene.yaml", leg_scene("5", "401"));
  EXPECT_NE(json(call)["rows"][0]["scene_hash"], whole["rows"][0]["scene_hash"]);
  const std::string grown = bytes_of(out);
  EXPECT_EQ(std::count(grown.begin(), grown.end(), '\n'), 10);
}

std::vector<std::string> sorted_lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  std::sort(lines.begin(), lines.end());
  return lines;
}

TEST_F(SweepVerb, MergeSaysWhatItLeavesOut) {
  const auto scene = write("scene.yaml", leg_scene()), out = folder_ / "rows.jsonl";
  ASSERT_EQ(run({"sweep", scene, "--set", "controller.target_hz=4,6", "--out", out}).exit_code, 0);
  const std::string rows = bytes_of(out);
  const auto cut = write("cut.jsonl", rows.substr(0, rows.size() - 9));
  const Said said = run({"merge", cut, "--out", folder_ / "all.jsonl"});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_NE(said.error.find("cut.jsonl: 1 line(s) without an end"), std::string::npos)
      << said.error;
  EXPECT_EQ(bytes_of(folder_ / "all.jsonl"), rows.substr(0, rows.find('\n') + 1));
  // A copy of what was known says nothing against what was computed since, and the order of files
  // of programs that were killed does not matter.
  ASSERT_EQ(run({"sweep", scene, "--set", "controller.target_hz=4,6", "--at", "20", "--out",
                 folder_ / "at.jsonl"})
                .exit_code,
            0);
  const std::string at = bytes_of(folder_ / "at.jsonl");
  const auto half = write("half.jsonl", rows.substr(0, 90));
  for (const std::vector<std::string>& files :
       {std::vector<std::string>{half, out, folder_ / "at.jsonl", out},
        {out, folder_ / "at.jsonl"}}) {
    std::vector<std::string> call{"merge", "--out", folder_ / "all.jsonl"};
    call.insert(call.end(), files.begin(), files.end());
    const Said merged = run(call);
    EXPECT_EQ(merged.exit_code, 0) << merged.error;
    EXPECT_NE(merged.error.find("2 row(s) answer what an earlier one"), std::string::npos)
        << merged.error;
    EXPECT_EQ(sorted_lines(bytes_of(folder_ / "all.jsonl")), sorted_lines(at));
  }
  expect_refused({"merge", out, folder_ / "nowhere.jsonl", "--out", folder_ / "none"}, 2,
                 "nowhere.jsonl: cannot be read");
  // Of one program that was killed while another wrote on.
  const std::string glued = rows.substr(0, 90) + "\n" + rows;
  EXPECT_EQ(run({"sweep", scene, "--set", "controller.target_hz=4,6", "--out",
                 write("glued.jsonl", glued)})
                .exit_code,
            0);
  EXPECT_EQ(bytes_of(folder_ / "glued.jsonl"), glued);
  expect_refused({"merge", write("notes.txt", "some notes\n"), "--out", folder_ / "none"}, 2,
                 "notes.txt: found a file that is neither a record of");
}

// Whichever --set comes first: the rows are known, and stand in the columns of their keys.
TEST_F(SweepVerb, TheOrderOfItsKeysMakesNoOtherRows) {
  const auto scene = write("scene.yaml", leg_scene()), out = folder_ / "rows.jsonl";
  const std::string a = "controller.target_hz=4,6", b = "controller.damping_ratio=0.5,0.7";
  const Said first = run({"sweep", scene, "--set", a, "--set", b, "--out", out});
  ASSERT_EQ(first.exit_code, 0) << first.error;
  const std::string rows = bytes_of(out);
  const Said swapped = run({"sweep", scene, "--set", b, "--set", a, "--out", out});
  EXPECT_EQ(swapped.exit_code, 0) << swapped.error;
  EXPECT_EQ(bytes_of(out), rows);
  const Said anew = run({"sweep", scene, "--set", b, "--set", a});
  EXPECT_EQ(swapped.output, anew.output);
}

TEST_F(SweepVerb, APointWithoutADesignIsSaidAndTheOthersStand) {
  const auto scene = write("scene.yaml", leg_scene());
  const Said said = run({"sweep", scene, "--set", "controller.delay_samples=-1,0,1,1.5", "--json"});
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.error.find("controller.delay_samples=-1: "), std::string::npos) << said.error;
  EXPECT_NE(said.error.find("scene.yaml:"), std::string::npos) << said.error;
  const Json rows = Json::parse(said.output)["rows"];
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_TRUE(rows[0]["stable"].is_null());
  EXPECT_TRUE(rows[0]["spectral_radius"].is_null());
  EXPECT_FALSE(rows[0]["failure"].is_null());
  EXPECT_EQ(rows[2]["stable"], true);
}

TEST_F(SweepVerb, BadKeysAndValuesAreOneMessage) {
  const auto scene = write("scene.yaml", leg_scene());
  const auto refused = [&](const std::string& set, const std::string& message) {
    expect_refused({"sweep", scene, "--set", set}, 2, message);
  };
  refused("controller.nothing=1,2", "controller.nothing: ");
  refused("elements.leg_c.stiffness=1", "has no such value");
  refused("elements=1", "has no such value");
  refused("controller.target_hz", "allowed is PATH=VALUE,VALUE,...");
  refused("controller.target_hz=1:2:0", "allowed is a whole number from 2 up");
  refused("controller.target_hz=0:2:3:log", "two numbers above 0");
  refused("controller.target_hz=1:x:3", "found 'x', allowed is a number");
  refused("controller.target_hz=1,,3", "a value is empty");
  refused("controller.target_hz=1:2:2000000", "allowed is a whole number from 2 up");
  expect_refused({"sweep", scene, "--set", "masses.1.mass=1,2", "--set", "masses.1.mass=3"}, 2,
                 "given twice");
  expect_refused({"sweep", scene, "--set", "masses.1.mass=1,2", "--at", "0"}, 2, "--at: found '0'");
  // Nothing of a file that is none of its own is taken away.
  for (const std::string text :
       {"a list\nof things", "not to be lost", R"({"title": "a scene"})"}) {
    const auto own = write("own.txt", text);
    expect_refused({"sweep", scene, "--set", "masses.1.mass=1,2", "--out", own.string()}, 2,
                   "found a line that is no row of a sweep");
    EXPECT_EQ(bytes_of(own), text);
  }
  expect_refused({"sweep", scene, "--set", "masses.1.mass=1,2", "--out", scene.string()}, 2,
                 "--out");
}

/// What a scene says once for several places is swept as it is written: a variable, or a value of
/// something that is repeated.
TEST_F(SweepVerb, ShorthandIsSweptAsItIsWritten) {
  const auto replaced = [](std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
      text.replace(at, what.size(), by);
    }
    return text;
  };
  const std::string plain = leg_scene("5", "400", "=k");
  const auto variable = write("variable.yaml", "variables: {m: 2, k: 4e5}\n" +
                                                   replaced(plain, "mass: 400", "mass: =200*m"));
  const Json rows =
      json({"sweep", variable, "--set", "variables.k=3e5,5e5", "--set", "variables.m=1,2"})["rows"];
  const auto legs_of = [](const std::string& k) {
    return "elements:\n  leg_#: {repeat: 2, type: truss, nodes: [floor, mass], stiffness: " + k +
           "}\n";
  };
  std::string repeated = leg_scene();
  const std::size_t from = repeated.find("elements:"), to = repeated.find("supports:");
  repeated.replace(from, to - from, legs_of("4e5"));
  repeated = replaced(replaced(repeated, "leg_a", "leg_1"), "leg_b", "leg_2");
  const Json legs =
      json({"sweep", write("repeated.yaml", repeated), "--set", "elements.leg_#.stiffness=3e5,5e5",
            "--set", "masses.mass.mass=200,400"})["rows"];
  ASSERT_EQ(rows.size(), 4u);
  ASSERT_EQ(legs.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Json design =
        json({"design", write("by_hand.yaml",
                              leg_scene("5", i % 2 == 0 ? "200" : "400", i < 2 ? "3e5" : "5e5"))});
    for (const Json& row : {rows[i], legs[i]}) {
      EXPECT_EQ(row["spectral_radius"], design["spectral_radius"]) << i;
      EXPECT_EQ(row["disk_margin"], design["margins"]["all_disk"]) << i;
    }
  }
  expect_refused({"sweep", variable, "--set", "variables.r=1"}, 2, "has no such value");
}

}  // namespace
}  // namespace stillframe::test

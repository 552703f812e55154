#include "tests/report/sample_log.hpp"
#include "tests/tools/verb.hpp"
#include "tools/json.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

/// Files that give their text once only, and texts that are no UTF-8.
class PipesAndBytes : public Verb {};

TEST_F(PipesAndBytes, ASceneThroughAPipeIsTheSceneOfItsFile) {
  std::string other = hanging_mass;
  other.replace(other.find("800"), 3, "900");
  std::vector<std::string> hashes;
  for (const std::string& text : {std::string(hanging_mass), other}) {
    const auto file = write("scene.yaml", text);
    const Said said =
        shell("cat '" + file.string() + "' | $BIN/stillframe modes /dev/stdin --json");
    ASSERT_EQ(said.exit_code, 0) << said.error;
    hashes.push_back(Json::parse(said.output).at("scene_hash"));
    EXPECT_EQ(hashes.back(), json({"modes", file}).at("scene_hash"));
  }
  EXPECT_NE(hashes[0], hashes[1]);
}

TEST_F(PipesAndBytes, ARunTakesASceneThroughAPipeButNothingThatItReadsTwice) {
  std::string text = text_of(config("scenes/metrology_frame.yaml"));
  const std::string controller = "../controllers/force_feedback_5hz.yaml",
                    floor = "../floors/vc_d.yaml";
  text.replace(text.find(controller), controller.size(),
               config("controllers/force_feedback_5hz.yaml"));
  text.replace(text.find(floor), floor.size(), "{white: {rms: 1e-3, duration_s: 2}}");
  const auto scene = write("scene.yaml", text);
  const auto piped = [&](const std::string& file, const std::string& arguments) {
    return shell("cd '" + folder_.string() + "'\ncat '" + file + "' | $BIN/stillframe run " +
                 arguments + " --loop active --duration 2 --out single_process");
  };
  const auto controller_file = config("controllers/force_feedback_5hz.yaml").string();
  const Said said = piped(scene, "/dev/stdin --mode single_process");
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_EQ(text_of(folder_ / "single_process/scene.yaml"), text);
  EXPECT_NE(text_of(folder_ / "single_process/floor.yaml").find("white"), std::string::npos);
  EXPECT_EQ(text_of(folder_ / "single_process/controller.yaml"), text_of(controller_file));
  std::filesystem::remove_all(folder_ / "single_process");
  const std::string by_pipe = "scene.yaml --controller /dev/stdin --mode ";
  EXPECT_EQ(piped(controller_file, by_pipe + "single_process").exit_code, 0);
  const Said refused = piped(controller_file, by_pipe + "lock_step");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.error.find("/dev/stdin: is no regular file"), std::string::npos)
      << refused.error;
}

TEST_F(PipesAndBytes, BytesThatAreNoUtf8AreRefusedWithTheirPlace) {
  std::string text = hanging_mass;
  const std::size_t name = text.find("push");
  text[name + 1] = '\xff';
  for (const char* verb : {"modes", "linearise"}) {
    for (const bool as_json : {false, true}) {
      std::vector<std::string> arguments{verb, write("scene.yaml", text)};
      if (as_json) arguments.emplace_back("--json");
      expect_refused(arguments, 2,
                     "scene.yaml:16:13: found the byte 0xff, allowed is text in UTF-8");
    }
  }
}

/// Names come from files and from the bus; on a terminal a control character is a command.
TEST_F(PipesAndBytes, NothingThatATerminalObeysIsPrinted) {
  const auto file = folder_ / "evil\033]0;title\007.lcm";
  {
    report::LogWriter log(file);
    auto info = report::sample_info(1, 20);
    info.scene_name = "scene\033[2J";
    info.leg_names[1] = "leg\x9b\xc2\x9b\r";
    log.write(channels::run_info, info);
    for (std::int64_t seq = 0; seq < 20; ++seq) {
      log.write(channels::measurement, report::sample_measurement(1, seq));
    }
  }
  const auto is_clean = [](const std::string& text) {
    return text.find_first_of("\033\007\r\x9b") == std::string::npos;
  };
  const Said exported = run({"export", file, "--csv", folder_ / "evil\033[2J.csv"});
  EXPECT_EQ(exported.exit_code, 0) << exported.error;
  EXPECT_NE(exported.output.find("evil\\x1b[2J.csv"), std::string::npos) << exported.output;
  EXPECT_TRUE(is_clean(exported.output)) << exported.output;
  const Said missing = run({"modes", folder_ / "evil\033]0;title\007.yaml"});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.error.find("evil\\x1b]0;title\\x07.yaml"), std::string::npos) << missing.error;
  EXPECT_TRUE(is_clean(missing.error)) << missing.error;
}

TEST_F(PipesAndBytes, ForeignNamesDoNotEndJson) {
  const auto file = folder_ / "foreign.lcm";
  {
    report::LogWriter log(file);
    auto info = report::sample_info(1, 20);
    info.scene_name = "sc\xe8ne";  // Latin-1
    info.leg_names[1] = "leg_\xff";
    log.write(channels::run_info, info);
    for (std::int64_t seq = 0; seq < 20; ++seq) {
      log.write(channels::measurement, report::sample_measurement(1, seq));
    }
  }
  const Json files =
      json({"export", file, "--csv", folder_ / "a\xff.csv", "--mat", folder_ / "a.mat"})
          .at("files");
  EXPECT_EQ(files.at(0).at("scene"), "sc\xef\xbf\xbdne");
  EXPECT_NE(tools::text_of(Json{{"name", "\xc3"}}).find("\xef\xbf\xbd"), std::string::npos);
}

}  // namespace
}  // namespace stillframe::test

#include <regex>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class BatchVerb : public Verb {
 protected:
  std::vector<std::string> two_by_two() const {
    const auto slower = write("slower.yaml",
                              "legs: [leg_1t, leg_1v, leg_2t, leg_2v, leg_3t, leg_3v]\n"
                              "target_hz: 4\ndamping_ratio: 0.7\nsample_rate_hz: 1000\n"
                              "delay_samples: 1\nlead_samples: 1.5\nleak_hz: 0.05\n");
    return {"batch",        config("scenes/metrology_frame.yaml"),
            "--controller", config("controllers/force_feedback_5hz.yaml"),
            "--controller", slower,
            "--floor",      config("floors/multisine.yaml"),
            "--floor",      config("floors/quake.yaml"),
            "--duration",   "6"};
  }
};

TEST_F(BatchVerb, RunsEveryCombinationInOrder) {
  const Json rows = json(two_by_two());
  ASSERT_EQ(rows.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    const auto names = [&](const char* key) { return rows[i].at(key).get<std::string>(); };
    EXPECT_NE(names("controller_file").find(i < 2 ? "5hz" : "slower"), std::string::npos) << i;
    EXPECT_NE(names("floor_file").find(i % 2 == 0 ? "multisine" : "quake"), std::string::npos) << i;
    EXPECT_EQ(rows[i].at("n_samples"), 6001) << i;
    // On a multisine the six outputs, too, and no floor, as each of its inputs moves on its own.
    EXPECT_EQ(rows[i].at("axes").size(), i % 2 == 0 ? 9u : 3u) << i;
    EXPECT_EQ(rows[i].at("axes")[0].at("floor_rms_m_s2").is_null(), i % 2 == 0) << i;
    EXPECT_GT(rows[i].at("peak_force_n").get<double>(), 0) << i;
  }
  // The same floor moves the passive frame alike whatever the gains are, to the bit.
  EXPECT_EQ(rows[0].at("axes")[0].at("passive_rms_m_s2"),
            rows[2].at("axes")[0].at("passive_rms_m_s2"));
  EXPECT_NE(rows[0].at("axes")[0].at("active_rms_m_s2"),
            rows[2].at("axes")[0].at("active_rms_m_s2"));
}

TEST_F(BatchVerb, AnswersTheSameOnAnyNumberOfThreads) {
  auto arguments = two_by_two();
  arguments.insert(arguments.end(), {"--jobs", "1"});
  Json one = json(arguments);
  arguments.back() = "3";
  Json three = json(arguments);
  for (Json* rows : {&one, &three}) {
    for (Json& row : *rows) row.erase("real_time_factor");
  }
  EXPECT_EQ(one, three);
}

TEST_F(BatchVerb, SaysWhichRunsFailedAndReportsTheOthers) {
  auto arguments = two_by_two();
  arguments.insert(arguments.end(), {"--floor", "nowhere.yaml", "--json"});
  const Said said = run(arguments);
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.error.find("nowhere.yaml: cannot be read"), std::string::npos) << said.error;
  const Json rows = Json::parse(said.output);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_FALSE(rows[0].contains("failure"));
  EXPECT_TRUE(rows[2].contains("failure"));
}

TEST_F(BatchVerb, FilesOfOneNameAreToldApart) {
  const auto still = write("still.yaml", "still: {duration_s: 0.1}\n");
  std::filesystem::create_directory(folder_ / "other");
  const auto other = write("other/still.yaml", "still: {duration_s: 0.1}\n");
  const auto floor = config("floors/multisine.yaml");
  const Said said = run({"batch", config("scenes/metrology_frame.yaml"), "--floor", still,
                         "--floor", other, "--floor", floor, "--duration", "0.1"});
  for (const std::string& name : {still.string(), other.string(), std::string(" multisine ")}) {
    EXPECT_NE(said.output.find(name), std::string::npos) << said.output;
  }
}

// It was left out of the table.
TEST_F(BatchVerb, ASceneThatComparesNothingHasARowToo) {
  std::string silent = text_of(config("scenes/metrology_frame.yaml"));
  const size_t compare = silent.find("\ncompare:"), next = silent.find("\n\n", compare);
  ASSERT_NE(next, std::string::npos);
  silent.erase(compare, next - compare);
  const Said said =
      run({"batch", write("silent.yaml", silent), config("scenes/metrology_frame.yaml"),
           "--controller", config("controllers/force_feedback_5hz.yaml"), "--floor",
           write("still.yaml", "still: {duration_s: 0.1}\n")});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  std::smatch row;
  ASSERT_TRUE(std::regex_search(said.output, row, std::regex("\n( *silent .*)\n"))) << said.output;
  EXPECT_TRUE(std::regex_search(row[1].str(), std::regex(R"( (- +){5}not judged +\S+ +\d+ *$)")))
      << row[1];
}

}  // namespace
}  // namespace stillframe::test

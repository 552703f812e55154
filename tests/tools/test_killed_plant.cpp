// Logs of a plant that was killed and came back in the same run, as a person reads them.
#include "msgs/message_fit.hpp"
#include "tests/tools/replay_logs.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

constexpr std::int64_t run_id = 7;

/// The messages of a recorded run as a plant of that number would have sent them.
class Recorded {
 public:
  Recorded(const std::filesystem::path& log, std::int64_t plant) : plant_(plant) {
    lcm::LogFile file(log.string(), "r");
    while (const lcm::LogEvent* event = file.readNextEvent()) take(*event);
  }

  /// All of it, or up to so many measurements.
  void write(Log& to, int most = 1 << 30) const {
    for (const LoggedMessage& message : messages_) {
      if (message.channel == channels::measurement && most-- == 0) return;
      to.push_back(message);
    }
  }

 private:
  void take(const lcm::LogEvent& event) {
    const std::string_view bytes(static_cast<const char*>(event.data),
                                 static_cast<std::size_t>(event.datalen));
    if (event.channel == channels::run_info) {
      give<stillframe_msgs::run_info_t>(
          event.channel, bytes, [](stillframe_msgs::run_info_t& info) { info.mode = "lock_step"; });
    } else if (event.channel == channels::measurement) {
      give<stillframe_msgs::measurement_t>(event.channel, bytes, [](auto&) {});
    } else if (event.channel == channels::command) {
      give<stillframe_msgs::command_t>(event.channel, bytes, [](auto&) {});
    }
  }

  template <class Message, class Change>
  void give(const std::string& channel, std::string_view bytes, Change&& change) {
    Message message;
    ASSERT_TRUE(decode(bytes, message));
    message.run_id = run_id;
    message.plant_instance = plant_;
    change(message);
    add(messages_, channel.c_str(), message);
  }

  std::int64_t plant_;
  Log messages_;
};

/// The passive run of a frame was killed after 3 s, and the active one came in its place.
class KilledPlant : public Verb {
 protected:
  void SetUp() override {
    Verb::SetUp();
    both_ = folder_ / "both.lcm", alone_ = folder_ / "alone.lcm", cut_ = folder_ / "cut.lcm";
    const Said said = run({"run", config("scenes/metrology_frame.yaml"), "--mode", "single_process",
                           "--duration", "8", "--out", folder_ / "run"});
    EXPECT_EQ(said.exit_code, 0) << said.error;
    const Recorded first(folder_ / "run/passive.lcm", 1001);
    const Recorded second(folder_ / "run/active.lcm", 1002);
    Log both, cut, alone;
    first.write(cut, 3000);
    write_log(cut_, cut);
    first.write(both, 3000);
    second.write(both);
    write_log(both_, both);
    second.write(alone);
    write_log(alone_, alone);
  }

  Json said(std::vector<std::string> words) const {
    words.push_back("--json");
    const Said found = run(words);
    EXPECT_LE(found.error.size(), 0u) << found.error;
    return Json::parse(found.output, nullptr, false);
  }

  static constexpr const char* warning =
      "run 7 was measured by 2 plants: plant 1 3000 samples, plant 2 8001 samples; those of plant "
      "2 "
      "are read and no others (--plant chooses)";

  static constexpr const char* left_out =
      "; what the controller counted over all of them by its end is left out and not judged.";

  std::filesystem::path both_, alone_, cut_;
};

TEST_F(KilledPlant, TheReportIsThatOfTheOneThatCameBackAndSaysSo) {
  Json both = said({"report", both_}), alone = said({"report", alone_});
  ASSERT_EQ(both.at("warnings").at(0), std::string("both.lcm: ") + warning + left_out);
  both["warnings"].erase(0);
  EXPECT_EQ(both, alone);
  const std::string page = text_of(folder_ / "both.html");
  EXPECT_NE(page.find(warning), std::string::npos);
  EXPECT_EQ(text_of(folder_ / "alone.html").find("was measured by"), std::string::npos);
  const std::string printed = run({"report", both_}).output;
  EXPECT_NE(printed.find(std::string("Warning: both.lcm: ") + warning), std::string::npos);

  // The other one is there too, for whoever wants to know how it ended.
  Json first = said({"report", both_, "--plant", "1"});
  first["warnings"].erase(0);
  EXPECT_EQ(first.at("runs")[0].at("loop"), "passive");
  EXPECT_EQ(first, said({"report", cut_}));
}

TEST_F(KilledPlant, TheExportIsThatOfTheOneThatCameBackAndSaysSo) {
  const auto exported = [&](const std::filesystem::path& log, const std::string& plant) {
    std::vector<std::string> words{"export",          log,     "--csv",
                                   folder_ / "a.csv", "--mat", folder_ / "a.mat"};
    if (!plant.empty()) words.insert(words.end(), {"--plant", plant});
    const Json document = said(words);
    return std::tuple(document.at("warnings"), document.at("files")[0].at("n_rows"),
                      text_of(folder_ / "a.csv"), text_of(folder_ / "a.mat"));
  };
  const auto both = exported(both_, ""), alone = exported(alone_, "");
  EXPECT_EQ(std::get<0>(both), Json({warning}));  // once, whatever the number of files
  EXPECT_EQ(std::get<0>(alone), Json::array());
  EXPECT_EQ(std::get<1>(both), 8001);
  EXPECT_TRUE(std::get<2>(both) == std::get<2>(alone));
  EXPECT_TRUE(std::get<3>(both) == std::get<3>(alone));
  EXPECT_TRUE(std::get<2>(exported(both_, "1")) == std::get<2>(exported(cut_, "")));
  const std::string printed = run({"export", both_, "--csv", folder_ / "a.csv"}).output;
  EXPECT_NE(printed.find(std::string("Warning: ") + warning), std::string::npos);
  expect_documented_keys("export", said({"export", both_, "--csv", folder_ / "a.csv"}));
  expect_refused({"export", both_, "--csv", folder_ / "b.csv", "--plant", "3"}, 2,
                 "plant: found 3, run 7 has 2 plants");
}

TEST_F(KilledPlant, TheIdentificationIsThatOfTheOneThatCameBackAndSaysSo) {
  Json both = said({"identify", both_}), alone = said({"identify", alone_});
  EXPECT_EQ(both.at("warnings"), Json({warning}));
  EXPECT_EQ(alone.at("warnings"), Json::array());
  both.erase("warnings"), alone.erase("warnings");
  EXPECT_EQ(both, alone);
  EXPECT_EQ(said({"identify", both_, "--plant", "1"}).at("loop"), "passive");
  const std::string printed = run({"identify", both_}).output;
  EXPECT_NE(printed.find(std::string("Warning: ") + warning), std::string::npos);
}

}  // namespace
}  // namespace stillframe::test

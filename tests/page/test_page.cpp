#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "report/page/figures_json.hpp"
#include "report/page/sections.hpp"
#include "report/page/write_page.hpp"
#include "tests/page/sample_page.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::page {
namespace {

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// The page without its own styles and scripts.
std::string without_code(std::string text) {
  const std::size_t style = text.find("<style>"), style_end = text.find("</style>");
  text.erase(style, style_end - style);
  const std::size_t script = text.rfind("<script>");
  text.erase(script, text.rfind("</script>") - script);
  return text;
}

std::vector<std::string> headings(const PageData& data) {
  std::vector<std::string> list;
  for (const Section& section : sections(data)) list.push_back(section.heading);
  return list;
}

TEST(Page, HasEveryPartInOrder) {
  const std::vector<std::string> expected = {
      "Result",      "Singular values", "Transmissibility", "Fit",
      "Mode shapes", "Time histories",  "Spectra",          "Settling after a shock",
      "Noise floor", "Actuator effort", "Timing",           "Record"};
  EXPECT_EQ(headings(test::sample_page(2)), expected);
}

TEST(Page, WarningsStandBeforeEverythingElseAndSevereOnesFirst) {
  PageData data = test::sample_page(2);
  data.warnings = {{Severity::note, "nnn"}, {Severity::severe, "sss"}, {Severity::warning, "www"}};
  const std::string text = without_code(page_text(data));
  const std::size_t severe = text.find("sss"), warning = text.find("www"), note = text.find("nnn");
  EXPECT_LT(severe, warning);
  EXPECT_LT(warning, note);
  EXPECT_LT(note, text.find("Passed"));
  EXPECT_LT(note, text.find("<section"));
}

TEST(Page, EmptyPartsHaveNoHeadings) {
  EXPECT_TRUE(headings({}).empty());
  const std::string text = without_code(page_text({}));
  for (const char* tag : {"<h2", "<h3", "<table", "<figure", "<details", "<nav", "<ul", "<dl"}) {
    EXPECT_EQ(count(text, tag), 0) << tag;
  }
  EXPECT_EQ(figures_json({}).dump(), "{}");
}

/// Each part taken out takes its heading with it, and nothing else.
TEST(Page, EachPartGoesWithItsHeading) {
  using Remove = void (*)(PageData&);
  const std::pair<const char*, Remove> parts[] = {
      {"Result", [](PageData& d) { d.result.clear(); }},
      {"Singular values", [](PageData& d) { d.singular_values.reset(); }},
      {"Transmissibility", [](PageData& d) { d.transmissibility.clear(); }},
      {"Fit", [](PageData& d) { d.fit.clear(); }},
      {"Mode shapes", [](PageData& d) { d.modes.reset(); }},
      {"Time histories", [](PageData& d) { d.histories.clear(), d.leg_forces.clear(); }},
      {"Spectra", [](PageData& d) { d.spectra = {}; }},
      {"Settling after a shock", [](PageData& d) { d.shock.clear(); }},
      {"Noise floor", [](PageData& d) { d.noise.clear(); }},
      {"Actuator effort", [](PageData& d) { d.effort.clear(); }},
      {"Timing", [](PageData& d) { d.timing.clear(), d.histograms.clear(); }},
      {"Record", [](PageData& d) { d.gains.clear(), d.texts.clear(), d.log.clear(); }}};
  const PageData whole = test::sample_page(2);
  for (const auto& [name, remove] : parts) {
    PageData data = whole;
    remove(data);
    std::vector<std::string> expected = headings(whole);
    std::erase(expected, name);
    EXPECT_EQ(headings(data), expected);
    EXPECT_EQ(page_text(data).find(">" + std::string(name) + "</"), std::string::npos) << name;
  }
}

/// An axis without a passive run, as of a log of the active loop alone.
TEST(Page, SignalsThatAreMissingAreLeftOut) {
  PageData data = test::sample_page(2);
  for (auto& axis : data.result) axis.passive.reset();
  for (auto& axis : data.histories) axis.passive = {};
  for (auto& axis : data.spectra.axes) axis.density.passive = {};
  const Json figures = figures_json(data);
  EXPECT_TRUE(figures["histories"]["axes"][0]["passive"].is_null());
  EXPECT_TRUE(figures["spectra"]["axes"][0]["density"]["passive"].is_null());
  EXPECT_EQ(count(sections(data).front().body, "key passive"), 0);
}

TEST(Page, HostileTextsStayTexts) {
  const std::string text = page_text(test::hostile_page()), body = without_code(text);
  EXPECT_EQ(count(body, "<img"), 0);
  EXPECT_EQ(count(body, "<script>window"), 0);
  // The data and the program, each closed once.
  EXPECT_EQ(count(text, "<script"), 2);
  EXPECT_EQ(count(text, "</script>"), 2);
  EXPECT_EQ(count(body, "<!--"), 0);
  EXPECT_GT(count(body, "&lt;img src=x onerror=&quot;"), 10);
  EXPECT_EQ(body.find('\0'), std::string::npos);
}

TEST(Page, DataComeBackFromThePage) {
  const PageData data = test::hostile_page();
  const std::string text = page_text(data), open = "id=\"stillframe-data\">";
  const std::size_t begin = text.find(open) + open.size();
  const Json read = Json::parse(text.substr(begin, text.find("</script>", begin) - begin));
  EXPECT_EQ(read["modes"]["nodes"][0]["name"], test::hostile_name);
  EXPECT_TRUE(read["singular_values"]["open"][0][3].is_null());
  EXPECT_TRUE(read["singular_values"]["closed_measured"]["values"][1][2].is_null());
  // Six digits are kept.
  const double value = data.singular_values->open(10, 2);
  EXPECT_NEAR(read["singular_values"]["open"][2][10].get<double>(), value, 1e-5 * value);
}

// A bare point looks better known than one with a bar.
TEST(Page, ValuesOfWhichNothingIsKnownAreCountedAndNotDrawn) {
  PageData data = test::sample_page(2);
  const auto caption = [&] { return sections(data)[1].body; };
  const auto value = [&](int line) {
    return figures_json(data)["singular_values"]["closed_measured"]["values"][5][line];
  };
  EXPECT_NE(caption().find("Left out: 1 of 600 measured values"), std::string::npos) << caption();
  EXPECT_NE(caption().find("reaches the bottom"), std::string::npos);
  EXPECT_TRUE(value(0).is_null());
  EXPECT_TRUE(value(1).is_number());
  MeasuredValues& measured = data.singular_values->closed_measured;
  measured.upper(0, 5) = 1;
  EXPECT_TRUE(value(0).is_number());
  EXPECT_EQ(caption().find("Left out"), std::string::npos);
  measured.lower(0, 5) = measured.lower(1, 5) = 1e-9;
  EXPECT_EQ(caption().find("reaches the bottom"), std::string::npos);
  data.transmissibility[1].active_measured.upper(3, 0) = HUGE_VAL;
  EXPECT_NE(sections(data)[2].body.find("Left out: 1 of 240 measured values"), std::string::npos)
      << sections(data)[2].body.substr(0, 400);
}

TEST(Page, LoadsNothingAndRunsOnlyItsOwnScript) {
  const std::string text = page_text(test::sample_page(2)), body = without_code(text);
  EXPECT_EQ(count(body, "src="), 0);
  EXPECT_EQ(count(body, "href=\"http"), 0);
  EXPECT_NE(text.find("default-src 'none'; script-src 'sha256-"), std::string::npos);
  EXPECT_EQ(count(text, "'unsafe-inline'"), 1) << "styles only";
}

/// The licences of what is bundled ask to be passed on.
TEST(Page, CarriesTheLicencesOfItsLibraries) {
  const std::string text = page_text({});
  for (const char* words : {"echarts 6", "zrender 6", "three 0.", "Apache License",
                            "Redistributions in binary form", "Permission is hereby granted"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words;
  }
}

/// The issue asks for 3 MB for 60 s at 1 kHz; longer runs must not grow.
TEST(Page, SizeIsBounded) {
  const std::size_t minute = page_text(test::sample_page(60)).size();
  EXPECT_LT(minute, 3'000'000u);
  PageData data = test::sample_page(60);
  for (int i = 0; i < 40; ++i) data.leg_forces.push_back(data.leg_forces[0]);
  EXPECT_LT(page_text(data).size(), 3'000'000u) << "with 46 legs";
}

TEST(Page, SizesThatDoNotFitAreRefusedByName) {
  const auto message = [](auto spoil) -> std::string {
    PageData data = test::sample_page(2);
    spoil(data);
    try {
      page_text(data);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message([](PageData& d) { d.singular_values->target.pop_back(); }).find("target"),
            std::string::npos);
  EXPECT_NE(
      message([](PageData& d) { d.modes->modes[0].displacement.resize(2, 3); }).find("mode shapes"),
      std::string::npos);
  EXPECT_NE(message([](PageData& d) { d.modes->elements[0].node_q = 99; }).find("arm_1"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) { d.histograms[0].counts.pop_back(); }).find("wake-up"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) { d.timing[0].rows[1].pop_back(); }).find("a row of 7 cells"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) { d.gains[0].rows.pop_back(); }).find("K_P"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) {
              d.transmissibility[1].active.pop_back();
            }).find("transmissibility y"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) { d.fit[1].passive.pop_back(); }).find("fit leg_1v"),
            std::string::npos);
  EXPECT_NE(message([](PageData& d) {
              d.spectra.axes[0].density.floor.values.pop_back();
            }).find("spectra"),
            std::string::npos);
}

class PageFile : public testing::Test {
 protected:
  const test::ScratchFolder scratch_;
  const std::filesystem::path& folder_ = scratch_.path();
};

TEST_F(PageFile, IsWrittenWholeAndNothingElseIsLeft) {
  const auto path = folder_ / "report.html";
  std::ofstream(path) << "old";
  write_page({}, path);
  std::ostringstream read;
  read << std::ifstream(path).rdbuf();
  EXPECT_EQ(read.str(), page_text({}));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST_F(PageFile, ThatCannotBeWrittenIsAnInputErrorThatNamesIt) {
  try {
    write_page({}, folder_ / "none" / "report.html");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("none/report.html"), std::string::npos);
  }
  std::filesystem::create_directory(folder_ / "taken.html");
  std::ofstream(folder_ / "taken.html" / "file") << "x";
  EXPECT_THROW(write_page({}, folder_ / "taken.html"), InputError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST(ResultTable, RatiosAreThoseOfItsRows) {
  PageData data;
  data.result = {{.axis = "x",
                  .floor = Level{1e-3, 4e-3, 4e-6, 12.5, "VC-D"},
                  .passive = Level{20e-3, 90e-3, 200e-6, 16, "above VC-A"},
                  .active = Level{0.5e-3, 1e-3, 1e-6, 4, "VC-F"}}};
  const std::string table = sections(data).front().body;
  for (const char* cell : {">1.00<", ">20.0<", ">0.500<", ">0.0250<", ">0.250<", ">0.00500<",
                           ">12.5<", ">above VC-A<"}) {
    EXPECT_NE(table.find(cell), std::string::npos) << cell;
  }
}

}  // namespace
}  // namespace stillframe::page

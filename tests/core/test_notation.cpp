#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>
#include <string>

// docs/notation.md names what the code has: every code name stands in the header that its row
// gives.
namespace stillframe::test {
namespace {

const std::string top = STILLFRAME_SOURCE_DIR "/";

std::string text_of(const std::string& path) {
  std::ifstream file(top + path);
  EXPECT_TRUE(file.good()) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// What stands between backticks in a cell.
std::vector<std::string> code_words(const std::string& cell) {
  static const std::regex quotes("`([^`]+)`");
  std::vector<std::string> words;
  for (std::sregex_iterator it(cell.begin(), cell.end(), quotes), end; it != end; ++it) {
    words.push_back((*it)[1]);
  }
  return words;
}

TEST(Notation, EveryCodeNameStandsInItsHeader) {
  std::istringstream text(text_of("docs/notation.md"));
  int names = 0;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with("| ") || line.starts_with("| symbol")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 6u) << line;
    std::string headers;
    for (const std::string& header : code_words(cells[5])) headers += text_of(header);
    for (const std::string& name : code_words(cells[1])) {
      ++names;
      // A private member carries an underscore at its end.
      EXPECT_TRUE(std::regex_search(headers, std::regex("\\b" + name + "_?\\b")))
          << name << " in" << cells[5];
    }
  }
  EXPECT_GT(names, 50);
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <random>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"
#include "core/yaml/load.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {
namespace {

/// What load_yaml says of a text; nothing if it takes it.
std::string error_of(const std::string& text) {
  try {
    load_yaml(text, "a.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string repeated(const std::string& text, std::size_t n) {
  std::string all;
  for (std::size_t i = 0; i < n; ++i) all += text;
  return all;
}

TEST(LoadYaml, TakesNoAnchorsAndAliases) {
  // Each of these once took the stack, all memory, or for ever.
  std::string bomb = "a: &a [x, x]\n";
  for (char name = 'b'; name <= 'z'; ++name) {
    const std::string before = "*" + std::string(1, static_cast<char>(name - 1));
    bomb += std::string(1, name) + ": &" + name + " [" + before + ", " + before + "]\n";
  }
  for (const std::string& text :
       {std::string("nodes: &a [*a]"), std::string("nodes: &a {b: *a}"), bomb,
        std::string("a: &b c"), std::string("&a b: c"), std::string("{a: &x , b: *x}")}) {
    EXPECT_NE(error_of(text).find("anchor"), std::string::npos) << text << error_of(text);
  }
  EXPECT_EQ(error_of("a: 1\nnodes: &a [*a]\n"),
            "a.yaml:2:8: nodes: found an anchor or alias (& or *), allowed are values written out");
  // They are letters like others inside a word.
  EXPECT_EQ(error_of("a: b&c*d\nb: \"&x *x\"\n"), "");
}

TEST(LoadYaml, IsBoundedInDepth) {
  for (const auto& [open, close] :
       {std::pair<std::string, std::string>{"[", "]"}, {"{a: ", "}"}, {"- ", ""}, {"? ", ""}}) {
    const auto nested = [&](std::size_t n) {
      return repeated(open, n) + "1" + repeated(close, n) + "\n";
    };
    // Of keys that are maps themselves not even one is taken.
    EXPECT_EQ(error_of(nested(most_yaml_depth)).empty(), open != "? ") << open;
    for (const std::size_t n : {most_yaml_depth + 1, std::size_t{400}, std::size_t{100'000}}) {
      EXPECT_NE(error_of(nested(n)), "") << open << " " << n;
    }
  }
  EXPECT_NE(error_of(repeated("[", 100'000)), "");
}

TEST(LoadYaml, IsBoundedInSizeAndNumberOfValues) {
  EXPECT_EQ(error_of("a: " + std::string(1'000'000, 'x')), "");
  EXPECT_EQ(error_of("# " + std::string(most_yaml_bytes, 'x')),
            "a.yaml: found 4194306 bytes, allowed are 4194304");
  const std::string many = "[" + repeated("1,", most_yaml_values) + "1]";
  EXPECT_NE(error_of(many).find("more than 300000 values"), std::string::npos) << error_of(many);
  EXPECT_NE(error_of(std::string(longest_yaml_key + 1, 'k') + ": 1"), "");
  EXPECT_EQ(error_of(std::string(longest_yaml_key, 'k') + ": 1"), "");
}

TEST(LoadYaml, AnEndlessFileIsRefused) {
  try {
    YamlReader::from_file("/dev/zero");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), std::string("/dev/zero: found 4194305 bytes, allowed are 4194304"));
  }
}

TEST(LoadYaml, TakesOneDocumentWithoutTags) {
  EXPECT_EQ(error_of("---\na: 1\n...\n"), "");
  EXPECT_NE(error_of("a: 1\n---\nb: 2\n").find("a.yaml:2:"), std::string::npos)
      << error_of("a: 1\n---\nb: 2\n");
  EXPECT_EQ(error_of("a: !!int 3\n"),
            "a.yaml:1:4: a: found the tag tag:yaml.org,2002:int, allowed are values without a tag");
  EXPECT_EQ(error_of("a: 'quoted'\nb: \"quoted\"\nc: plain\nd: []\ne: {}\nf:\n"), "");
}

TEST(LoadYaml, KeysAreWordsAndStandOnce) {
  EXPECT_NE(error_of("a: {b: 1, c: {d: 1}, b: 2}").find("a.b: this key stands twice"),
            std::string::npos)
      << error_of("a: {b: 1, c: {d: 1}, b: 2}");
  EXPECT_NE(error_of("[a]: 1"), "");
  EXPECT_NE(error_of("{a: 1}: 1"), "");
  EXPECT_NE(error_of(": 1"), "");
  EXPECT_EQ(error_of("a: {b: 1}\nb: {a: 1, b: 2}\n"), "");
}

TEST(LoadYaml, TakesPrintableTextOnly) {
  for (const std::string& bytes : {std::string("\x1b[2J"), std::string(1, '\0'),
                                   std::string("\x7f"), std::string("\xc2\x9b")}) {
    EXPECT_NE(error_of("a: b" + bytes).find("allowed is printable text"), std::string::npos);
  }
  EXPECT_EQ(error_of("a: \xc3\xa9\xc2\xa0\r\nb: c\td\n"), "");
}

/// A message never carries what a terminal would obey, nor more than a person reads.
TEST(LoadYaml, MessagesArePrintable) {
  const auto reader = YamlReader::from_text(
      "{\"\\e[31m\": \"\\e]0;owned\\a\", long: " + std::string(100'000, 'x') + "}", "a.yaml");
  for (const auto& [key, value] : reader.entries()) {
    try {
      value.number();
      FAIL() << "accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_LT(message.size(), 300u);
      for (const char c : message) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
    }
  }
}

/// Random bytes, and random changes to a sound text: an InputError or a tree, nothing else, and a
/// tree that is written and read again is the same.
TEST(LoadYaml, AnyBytesAreATreeOrAnInputError) {
  const std::string sound =
      "title: a\nnodes:\n  b: {position: [0, 1.5, -2e3]}\n  'c': \"d\\n\"\ne:\n- f\n- {g: [h, ]}\n";
  std::mt19937_64 random(15);
  int n_trees = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string text = sound;
    for (std::uint64_t n = 1 + random() % 4; n > 0; --n) {
      constexpr std::string_view marks = "&*!?:-[]{},|>%@\"'#\n \t~a0";
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = marks[random() % marks.size()];
          break;
        case 1:
          text.insert(at, 1, marks[random() % marks.size()]);
          break;
        default:
          text.erase(at, 1 + random() % 5);
      }
      if (text.empty()) text = "a";
    }
    try {
      const YAML::Node tree = load_yaml(text, "a");
      const std::string written = YAML::Dump(tree);
      EXPECT_EQ(YAML::Dump(load_yaml(written, "b")), written) << text;
      ++n_trees;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(n_trees, 2000);
  EXPECT_LT(n_trees, 18'000);
}

TEST(Printable, CutsAndEscapes) {
  EXPECT_EQ(printable("a\x1b[b", 80), "a\\x1b[b");
  EXPECT_EQ(printable("\xc2\x9b\xc3\xa9\xff", 80), "\\xc2\\x9b\xc3\xa9\\xff");
  EXPECT_EQ(printable("abcdef", 4), "abcd...");
  EXPECT_EQ(printable("abc\xc3\xa9", 4), "abc...");  // no half of a letter
}

}  // namespace
}  // namespace stillframe

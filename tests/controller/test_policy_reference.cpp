#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "controller/policy.hpp"
#include "core/errors/input_error.hpp"
#include "tests/controller/policy_fields.hpp"

// docs/safety.md and config/policies/default.yaml are held to the reader: the same keys, defaults
// and bounds.
namespace stillframe::controller {
namespace {

std::string text_of(const std::string& file) {
  std::ifstream stream(std::string(STILLFRAME_SOURCE_DIR) + "/" + file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

struct Row {
  std::string unit, otherwise, allowed;
};

/// Rows of every table of the policy, by the heading above it, "The file" or the name of a block.
std::map<std::string, std::map<std::string, Row>> tables() {
  std::map<std::string, std::map<std::string, Row>> result;
  std::istringstream text(text_of("docs/safety.md"));
  std::string line, heading;
  bool policy = false;
  while (std::getline(text, line)) {
    if (line.starts_with("## ")) policy = line == "## The policy file";
    if (line.starts_with("### ")) heading = line.substr(4);
    if (!policy || !line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');) {
      const size_t first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    EXPECT_EQ(cells.size(), 5u) << line;
    const std::string key = cells[0].substr(1, cells[0].size() - 2);
    EXPECT_TRUE(result[heading].emplace(key, Row{cells[1], cells[2], cells[3]}).second) << line;
  }
  return result;
}

const std::string top = "The file";
const std::string blocks = "a block";

/// A policy of one key. A power limit brings the stiffness that it needs, and the reverse.
std::string document(const std::string& table, const std::string& key, const std::string& value) {
  if (table == top) return key + ": " + value;
  std::string more;
  if (key == "power_w") more = ", actuator_stiffness_n_per_m: 1";
  if (key == "actuator_stiffness_n_per_m") more = ", power_w: 1";
  return table + ": {" + key + ": " + value + more + "}";
}

std::string error_of(const std::string& text) {
  try {
    parse_policy(text, "policy.yaml", 1000);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string digits(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

/// Values on both sides of every bound that an "allowed" cell states.
struct Samples {
  std::vector<std::string> good, bad;
};

Samples samples_of(const std::string& allowed) {
  std::smatch found;
  const auto above = [](double x) {
    return digits(std::nextafter(x, std::numeric_limits<double>::infinity()));
  };
  const auto below = [](double x) {
    return digits(std::nextafter(x, -std::numeric_limits<double>::infinity()));
  };
  if (std::regex_match(allowed, found, std::regex(R"(whole, (\S+) to (\S+))"))) {
    const auto low = std::stoll(found[1]), high = std::stoll(found[2]);
    return {{std::to_string(low), std::to_string(high)},
            {std::to_string(low - 1), std::to_string(high + 1), digits(double(low) + 0.5)}};
  }
  if (std::regex_match(allowed, found, std::regex(R"(above 0, up to (\S+))"))) {
    const double high = std::stod(found[1]);
    return {{"1e-300", digits(high)}, {"0", "-1", above(high), ".inf", ".nan"}};
  }
  if (allowed == "above 0") {
    return {{"1e-300", "1e12"}, {"0", "-1", above(1e12), ".inf", ".nan", "much"}};
  }
  if (std::regex_match(allowed, found, std::regex(R"(([0-9.e-]+) to ([0-9.e-]+))"))) {
    const double low = std::stod(found[1]), high = std::stod(found[2]);
    return {{digits(low), digits(high)}, {below(low), above(high), ".nan"}};
  }
  Samples words;
  const std::regex word("`([a-z_]+)`");
  for (std::sregex_iterator it(allowed.begin(), allowed.end(), word), end; it != end; ++it) {
    words.good.push_back((*it)[1]);
    words.bad.push_back((*it)[1].str() + "x");
  }
  EXPECT_FALSE(words.good.empty()) << "no bounds in: " << allowed;
  return words;
}

std::set<std::string> allowed_keys(const std::string& message) {
  const std::string marker = "; allowed: ";
  const size_t at = message.find(marker);
  EXPECT_NE(at, std::string::npos) << message;
  std::set<std::string> keys;
  std::istringstream list(message.substr(at + marker.size()));
  for (std::string key; std::getline(list, key, ',');) {
    keys.insert(key.substr(key.find_first_not_of(' ')));
  }
  return keys;
}

TEST(PolicyReference, HasATableForEveryBlockAndListsExactlyTheKeysOfTheReader) {
  const auto all = tables();
  ASSERT_TRUE(all.contains(top));
  for (const auto& [key, row] : all.at(top)) {
    EXPECT_EQ(all.contains(key), row.allowed == blocks) << key;
  }
  EXPECT_EQ(all.size(), 10u);  // the file and its nine blocks
  for (const auto& [table, rows] : all) {
    const std::string unknown = table == top ? "no_such_key: 1" : table + ": {no_such_key: 1}";
    std::set<std::string> documented;
    for (const auto& [key, row] : rows) documented.insert(key);
    EXPECT_EQ(allowed_keys(error_of(unknown)), documented) << table;
  }
}

TEST(PolicyReference, DefaultsAreThoseOfAnEmptyPolicy) {
  for (const auto& [table, rows] : tables()) {
    for (const auto& [key, row] : rows) {
      if (row.allowed == blocks || row.otherwise == "none" || row.otherwise == "any") continue;
      std::string value = row.otherwise;
      std::erase(value, '`');
      EXPECT_EQ(fields(parse_policy(document(table, key, value), "", 1000)), fields(Policy{}))
          << table << ": " << key;
    }
  }
}

TEST(PolicyReference, BoundsAreThoseOfTheReader) {
  for (const auto& [table, rows] : tables()) {
    for (const auto& [key, row] : rows) {
      if (row.allowed == blocks) continue;
      const Samples samples = samples_of(row.allowed);
      for (const std::string& value : samples.good) {
        EXPECT_EQ(error_of(document(table, key, value)), "") << table << "." << key;
      }
      for (const std::string& value : samples.bad) {
        const std::string name = table == top ? key : table + "." + key;
        EXPECT_NE(error_of(document(table, key, value)).find(name), std::string::npos)
            << name << ": " << value << " should have been refused";
      }
    }
  }
}

TEST(PolicyReference, UnitsAreThoseOfTheNames) {
  const std::map<std::string, std::string> endings{
      {"_n_per_s", "N/s"}, {"_n_per_m", "N/m"}, {"_n", "N"},  {"_s", "s"},
      {"_w", "W"},         {"_mb", "MB"},       {"_hz", "Hz"}};
  for (const auto& [table, rows] : tables()) {
    for (const auto& [key, row] : rows) {
      std::string unit;
      size_t longest = 0;
      for (const auto& [ending, name] : endings) {
        if (!key.ends_with(ending) || ending.size() <= longest) continue;
        longest = ending.size();
        unit = name;
      }
      if (unit.empty() && key.ends_with("_periods")) unit = "periods";
      EXPECT_EQ(row.unit, unit) << table << "." << key;
    }
  }
}

/// The keys without a default stand in comments; with these taken as keys the file has them all.
TEST(PolicyReference, TheDefaultFileHasEveryKey) {
  std::string text = text_of("config/policies/default.yaml");
  text = std::regex_replace(text, std::regex("\n# limits:"), "\nlimits:");
  text = std::regex_replace(text, std::regex("\n#   "), "\n  ");
  EXPECT_EQ(error_of(text), "");
  for (const auto& [table, rows] : tables()) {
    for (const auto& [key, row] : rows) {
      const std::string line = "\n" + std::string(table == top ? "" : "  ") + key + ":";
      const size_t from = table == top ? 0 : text.find("\n" + table + ":");
      ASSERT_NE(from, std::string::npos) << table;
      EXPECT_NE(text.find(line, from), std::string::npos) << table << "." << key;
    }
  }
}

}  // namespace
}  // namespace stillframe::controller

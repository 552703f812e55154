#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <regex>
#include <string>

#include "core/errors/input_error.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {
namespace {

void expect_same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  if (a.size() == 0) return;  // there may be no address to compare at
  EXPECT_EQ(0, std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<size_t>(a.size())));
}

void expect_same(const Gains& a, const Gains& b) {
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(a.legs, b.legs);
  EXPECT_EQ(a.sample_rate_hz, b.sample_rate_hz);
  EXPECT_EQ(a.delay_samples, b.delay_samples);
  EXPECT_EQ(a.target_hz, b.target_hz);
  EXPECT_EQ(a.realisation, b.realisation);
  EXPECT_EQ(a.leak_hz, b.leak_hz);
  EXPECT_EQ(a.lead_samples, b.lead_samples);
  EXPECT_EQ(a.roll_off_hz, b.roll_off_hz);
  EXPECT_EQ(a.force_limit_n, b.force_limit_n);
  expect_same_bits(a.K_P, b.K_P);
  expect_same_bits(a.K_I, b.K_I);
  expect_same_bits(a.plant.A, b.plant.A);
  expect_same_bits(a.plant.B, b.plant.B);
  expect_same_bits(a.plant.C, b.plant.C);
  expect_same_bits(a.plant.B_w, b.plant.B_w);
  expect_same_bits(a.plant.A_w, b.plant.A_w);
  expect_same_bits(a.plant.C_w, b.plant.C_w);
}

// Every bit pattern of a double up to `highest` is as likely as any other: all exponents, both
// signs.
double any_double(std::mt19937_64& random, double highest) {
  for (;;) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::abs(value) <= highest) return value;
  }
}

TEST(Gains, ReadingBackIsBitExact) {
  std::mt19937_64 random(20240607);
  Gains gains = toy::gains(5);
  gains.plant.A_w.resize(8, 2);
  gains.plant.C_w.resize(4, 2);
  for (int round = 0; round < 50; ++round) {
    for (auto* M : {&gains.K_P, &gains.K_I, &gains.plant.A, &gains.plant.B, &gains.plant.C,
                    &gains.plant.B_w, &gains.plant.A_w, &gains.plant.C_w}) {
      *M = M->unaryExpr([&](double) { return any_double(random, 1e18); });
    }
    gains.sample_rate_hz = 1 + std::abs(any_double(random, 999'999));
    gains.leak_hz = std::abs(any_double(random, 1e6));
    expect_same(gains, parse_gains(to_yaml(gains), "text"));
  }
}

TEST(Gains, OptionalKeysAndNamesSurvive) {
  Gains gains = toy::gains(5, 4000, 0);
  gains.realisation = Realisation::naive_pi;
  gains.target_hz = {5, 20.0 / 3};
  gains.lead_samples = 1.0 / 7;
  gains.roll_off_hz = 0.1;
  gains.force_limit_n = 1.0 / 3;
  gains.scene_hash = "0000000000000012";  // all digits, and still text
  gains.legs = {"mount 1: tangential", "quote \" and \\", "tab\t", "# no comment"};
  expect_same(gains, parse_gains(to_yaml(gains), "text"));
}

struct BadFile {
  const char* name;
  const char* find;     // in the YAML of the toy gains
  const char* replace;  // with this
  const char* place;    // that the message must name
  const char* key;      // that the message must name
};

class BadGains : public testing::TestWithParam<BadFile> {};

TEST_P(BadGains, IsRefusedWithPlaceAndKey) {
  std::string text = to_yaml(toy::gains(5));
  const size_t at = text.find(GetParam().find);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::strlen(GetParam().find), GetParam().replace);
  try {
    parse_gains(text, "gains.yaml");
    FAIL() << "accepted:\n" << text;
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(GetParam().place), std::string::npos) << message;
    EXPECT_NE(message.find(GetParam().key), std::string::npos) << message;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Keys, BadGains,
    testing::Values(
        BadFile{"version", "stillframe_gains: 1", "stillframe_gains: 2", "gains.yaml:1",
                "stillframe_gains"},
        BadFile{"no_version", "stillframe_gains: 1\n", "", "gains.yaml", "stillframe_gains"},
        BadFile{"unknown", "leak_hz", "leek_hz", "gains.yaml:7", "leak_hz"},
        BadFile{"missing", "delay_samples: 1\n", "", "gains.yaml", "delay_samples"},
        BadFile{"delay", "delay_samples: 1", "delay_samples: -1", "gains.yaml:5", "delay_samples"},
        BadFile{"rate", "sample_rate_hz: 1000", "sample_rate_hz: 0", "gains.yaml:4",
                "sample_rate_hz"},
        BadFile{"unit", "sample_rate_hz: 1000", "sample_rate_hz: 1 kHz", "gains.yaml:4",
                "sample_rate_hz"},
        BadFile{"leak", "leak_hz: 0.05", "leak_hz: -0.05", "gains.yaml:7", "leak_hz"},
        BadFile{"nan", "leak_hz: 0.05", "leak_hz: .nan", "gains.yaml:7", "leak_hz"},
        BadFile{"realisation", "implicit_feedthrough", "explicit", "gains.yaml:6", "realisation"},
        BadFile{"legs_twice", "\"leg_2\"", "\"leg_1\"", "gains.yaml:3", "legs"},
        BadFile{"leg_missing", ", \"leg_4\"", "", "gains.yaml:", "K_P"},
        BadFile{"short_row", "  - [0, 0", "  - [0", "gains.yaml:", "K_P"},
        BadFile{"infinite", "  - [0, 0", "  - [.inf, 0", "gains.yaml:", "K_P"},
        BadFile{"limit", "force_limit_n: 200", "force_limit_n: 0", "gains.yaml:8", "force_limit_n"},
        BadFile{"roll_off", "K_P:", "roll_off_hz: -1\nK_P:", "gains.yaml:9", "roll_off_hz"},
        BadFile{"plant_key", "  C:\n", "  D:\n", "gains.yaml:", "plant"}),
    [](const auto& test) { return test.param.name; });

std::string error_of(const std::string& text) {
  try {
    parse_gains(text, "gains.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// The toy gains with one key at a value.
std::string with(const std::string& key, const std::string& value) {
  std::string text = to_yaml(toy::gains(5));
  const bool of_instruments =
      key.starts_with("actuator") || key.starts_with("sensor") || key.starts_with("report");
  const std::string line = of_instruments       ? "instruments: {" + key + ": " + value + "}\n"
                           : key == "target_hz" ? key + ": [" + value + "]\n"
                                                : key + ": " + value + "\n";
  const std::size_t there = text.find("\n" + key + ":");
  if (there == std::string::npos) return text.insert(text.find("K_P:"), line);
  return text.replace(there + 1, text.find('\n', there + 1) - there, line);
}

std::string digits(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}

// The table of docs/inputs.md is held to the reader on both sides of both ends.
TEST(Gains, RangesAreThoseOfTheReference) {
  std::ifstream file(std::string(STILLFRAME_SOURCE_DIR) + "/docs/inputs.md");
  const std::regex row(R"(\| `([a-z_]+)` \| [^|]* \| [^|]* \| (\S+|above 0, up) (?:to )?(\S+) \|)");
  int n_rows = 0;
  for (std::string line; std::getline(file, line);) {
    std::smatch found;
    if (!std::regex_match(line, found, row)) continue;
    ++n_rows;
    const std::string key = found[1];
    const bool above = found[2] == "above 0, up";
    const double low = above ? 0 : std::stod(found[2]), high = std::stod(found[3]);
    const bool whole = key == "report_age_samples";
    const double beyond = whole ? high + 1 : std::nextafter(high, 2 * high);
    const double below = whole ? low - 1 : std::nextafter(low, -1);
    EXPECT_EQ(error_of(with(key, digits(above ? 1e-300 : low))), "") << line;
    EXPECT_EQ(error_of(with(key, digits(high))), "") << line;
    for (const std::string& bad :
         {digits(beyond), digits(above ? 0 : below), std::string("1e308"), std::string("-1e308"),
          std::string(".nan"), std::string(".inf")}) {
      const std::string message = error_of(with(key, bad));
      EXPECT_NE(message.find(key + (key == "target_hz" ? "[1]: found" : ": found")),
                std::string::npos)
          << key << " " << bad << ": " << message;
      EXPECT_NE(message.find("gains.yaml:"), std::string::npos) << message;
      EXPECT_NE(message.find("allowed"), std::string::npos) << message;
    }
  }
  EXPECT_EQ(n_rows, 12);
}

TEST(Gains, EntriesOfMatricesHaveABound) {
  for (const double entry : {1e18, -1e18}) {
    Gains gains = toy::gains(5);
    gains.K_I(2, 1) = gains.plant.A(3, 4) = gains.plant.B(7, 0) = gains.plant.C(0, 7) = entry;
    gains.plant.B_w = Eigen::MatrixXd::Constant(8, 3, entry);
    EXPECT_EQ(error_of(to_yaml(gains)), "");
    for (auto* M : {&gains.K_P, &gains.K_I, &gains.plant.A, &gains.plant.B, &gains.plant.C,
                    &gains.plant.B_w}) {
      const double before = (*M)(1, 2);
      (*M)(1, 2) = std::nextafter(entry, 10 * entry);
      const std::string message = error_of(to_yaml(gains));
      EXPECT_NE(message.find("[2][3]: found"), std::string::npos) << message;
      (*M)(1, 2) = before;
    }
  }
}

TEST(Gains, AFloorHasABoundedNumberOfChannels) {
  Gains gains = toy::gains(5);
  gains.plant.B_w = Eigen::MatrixXd::Zero(8, 64);
  EXPECT_EQ(error_of(to_yaml(gains)), "");
  gains.plant.B_w = Eigen::MatrixXd::Zero(8, 65);
  const std::string message = error_of(to_yaml(gains));
  EXPECT_NE(message.find("plant.B_w: found 65 columns, allowed are up to 64"), std::string::npos)
      << message;
}

// Velocity and position of each channel of the floor, for the states and for the legs.
TEST(Gains, WhatTheFloorsPositionDoesFitsItsChannels) {
  const auto with = [](Eigen::Index states, Eigen::Index legs, Eigen::Index channels) {
    Gains gains = toy::gains(5);
    gains.plant.A_w = Eigen::MatrixXd::Ones(states, channels);
    gains.plant.C_w = Eigen::MatrixXd::Ones(legs, channels);
    return to_yaml(gains);
  };
  EXPECT_EQ(error_of(with(8, 4, 2)), "");
  EXPECT_NE(error_of(with(7, 4, 2)).find("plant.A_w"), std::string::npos);
  EXPECT_NE(error_of(with(8, 3, 2)).find("plant.C_w"), std::string::npos);
  EXPECT_NE(error_of(with(8, 4, 1)).find("plant.A_w"), std::string::npos);
  const std::string text = with(8, 4, 2);
  const auto without = [&](const std::string& key, const std::string& next) {
    const auto from = text.find("  " + key + ":\n");
    return text.substr(0, from) + (next.empty() ? "" : text.substr(text.find("  " + next + ":\n")));
  };
  EXPECT_NE(error_of(without("C_w", "")).find("C_w"), std::string::npos);
  EXPECT_NE(error_of(without("A_w", "C_w")).find("A_w"), std::string::npos);
  EXPECT_NE(error_of(without("B_w", "A_w")).find("B_w"), std::string::npos);
}

// What is under way is states of the loop, and a judgement takes the cube of these.
TEST(Gains, ALoopHasABoundedNumberOfStates) {
  Gains gains = toy::gains(5);
  for (int i = 5; i <= 30; ++i) gains.legs.push_back("leg_" + std::to_string(i));
  const Eigen::Index m = gains.n_legs(), n = 2 * m;
  gains.K_P = gains.K_I = Eigen::MatrixXd::Identity(m, m);
  gains.plant = {Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, m),
                 Eigen::MatrixXd::Zero(m, n), Eigen::MatrixXd::Zero(n, 0)};
  gains.delay_samples = 3;
  EXPECT_EQ(most_loop_states(gains), 390);
  EXPECT_EQ(error_of(to_yaml(gains)), "");
  gains.delay_samples = 3.5;
  EXPECT_NE(error_of(to_yaml(gains)).find("found a loop of 420 states"), std::string::npos)
      << error_of(to_yaml(gains));
}

TEST(Gains, ThePlantIsTheOneThatWasWritten) {
  std::string text = to_yaml(toy::gains(5));
  const std::size_t at = text.find("-15791.");
  text[at + 7] = text[at + 7] == '3' ? '4' : '3';
  EXPECT_NE(error_of(text).find("plant.hash: found "), std::string::npos) << error_of(text);
  // The law may be changed; the order of the legs is the plant's.
  EXPECT_EQ(error_of(with("leak_hz", "0.1")), "");
  EXPECT_NE(error_of(with("scene_hash", "other")).find("plant.hash"), std::string::npos);
  std::string swapped = to_yaml(toy::gains(5));
  swapped.replace(swapped.find("\"leg_1\", \"leg_2\""), 16, "\"leg_2\", \"leg_1\"");
  EXPECT_NE(error_of(swapped).find("plant.hash"), std::string::npos);
  // Somebody's own plant has none.
  const std::size_t hash = text.find("  hash:");
  text.erase(hash, text.find('\n', hash) + 1 - hash);
  EXPECT_EQ(error_of(text), "");
}

TEST(Gains, MissingFileIsAnInputError) {
  EXPECT_THROW(read_gains("no/such/gains.yaml"), InputError);
}

}  // namespace
}  // namespace stillframe::controller

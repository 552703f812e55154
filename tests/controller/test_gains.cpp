#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>

#include "controller/gains.hpp"
#include "core/yaml/input_error.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {
namespace {

void expect_same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
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
}

// Every bit pattern of a finite double is as likely as any other: all exponents, both signs.
double any_double(std::mt19937_64& random) {
  for (;;) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) return value;
  }
}

TEST(Gains, ReadingBackIsBitExact) {
  std::mt19937_64 random(20240607);
  Gains gains = toy::gains(5);
  for (int round = 0; round < 50; ++round) {
    for (auto* M : {&gains.K_P, &gains.K_I, &gains.plant.A, &gains.plant.B, &gains.plant.C}) {
      *M = M->unaryExpr([&](double) { return any_double(random); });
    }
    gains.sample_rate_hz = std::abs(any_double(random));
    gains.leak_hz = std::abs(any_double(random));
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
        BadFile{"limit", "K_P:", "force_limit_n: 0\nK_P:", "gains.yaml:8", "force_limit_n"},
        BadFile{"roll_off", "K_P:", "roll_off_hz: -1\nK_P:", "gains.yaml:8", "roll_off_hz"},
        BadFile{"plant_key", "  C:\n", "  D:\n", "gains.yaml:", "plant"}),
    [](const auto& test) { return test.param.name; });

TEST(Gains, MissingFileIsAnInputError) {
  EXPECT_THROW(read_gains("no/such/gains.yaml"), InputError);
}

}  // namespace
}  // namespace stillframe::controller

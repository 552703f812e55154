#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/systems/sampled_loop.hpp"
#include "judge/loop_design.hpp"
#include "tests/fuzz/decay.hpp"

namespace stillframe::controller {
namespace {

struct Design {
  const char *scene, *controller;
};

void PrintTo(const Design& design, std::ostream* out) {
  *out << design.scene << " " << design.controller;
}

/// Where the numbers of a text stand. Of a gains file those of the version are left alone.
struct Place {
  std::size_t at, length;
};

std::vector<Place> numbers_of(const std::string& text) {
  static const std::regex number(R"([-\[: ](-?[0-9]+\.?[0-9]*(e[-+][0-9]+)?)(?=[,\]\n]))");
  std::vector<Place> places;
  const auto from = text.begin() + static_cast<std::ptrdiff_t>(text.find("sample_rate_hz"));
  for (std::sregex_iterator it(from, text.end(), number), end; it != end; ++it) {
    places.push_back({static_cast<std::size_t>(it->position(1) + (from - text.begin())),
                      static_cast<std::size_t>(it->length(1))});
  }
  return places;
}

/// One number made another: small and large changes, the sign, a digit, powers of ten, the edges.
std::string mutated(const std::string& number, std::mt19937_64& random) {
  const double value = std::stod(number);
  std::uniform_real_distribution<double> uniform(-1, 1);
  char buffer[40];
  const auto shown = [&](double x) {
    std::snprintf(buffer, sizeof buffer, "%.17g", x);
    return std::string(buffer);
  };
  switch (random() % 8) {
    case 0:
      return shown(value * (1 + 0.1 * uniform(random)));
    case 1:
      return shown(value * std::pow(10, 3 * uniform(random)));
    case 2:
      return shown(value * std::pow(10, 300 * uniform(random)));
    case 3:
      return shown(-value);
    case 4:
      return shown(std::pow(10, 20 * uniform(random)));
    case 5:
      return shown(value + 100 * uniform(random));
    case 6: {
      std::string text = number;
      text[text.find_first_of("0123456789")] = static_cast<char>('0' + random() % 10);
      return text;
    }
    default: {
      constexpr const char* edges[] = {"0",        "1e308", "-1e308", "1e-300",
                                       "4.9e-324", "1e18",  "1e6",    ".nan"};
      return edges[random() % std::size(edges)];
    }
  }
}

/// What came of a mutated gains file.
enum class Outcome { out_of_range, unstable, runs };

Outcome outcome_of(const std::string& text) {
  try {
    const Gains gains = parse_gains(text, "mutated");
    try {
      if (!(closed_loop_radius(gains) < largest_stable_radius)) return Outcome::unstable;
    } catch (const Refusal&) {
      return Outcome::unstable;
    }
    EXPECT_TRUE(fuzz::decays(gains)) << text;
    return Outcome::runs;
  } catch (const InputError&) {
    return Outcome::out_of_range;
  }
}

class Mutations : public testing::TestWithParam<Design> {
 protected:
  Mutations() {
    const auto config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";
    const Design& design = GetParam();
    const auto controller = config / "controllers" / (std::string(design.controller) + ".yaml");
    gains_ = judge::make_loop_design(config / "scenes" / (std::string(design.scene) + ".yaml"),
                                     *design.controller ? std::optional(controller) : std::nullopt,
                                     std::nullopt)
                 .gains;
  }
  Gains gains_;
};

// The gains of a shipped design with any of its numbers changed: refused, or a loop that decays
// when it is stepped through 100 000 samples with these very matrices.
TEST_P(Mutations, AreRefusedOrDecay) {
  std::string text = to_yaml(gains_);
  ASSERT_EQ(outcome_of(text), Outcome::runs);
  // The hash would refuse all changes of the plant; without it they are judged.
  const std::size_t hash = text.find("  hash:");
  text.erase(hash, text.find('\n', hash) + 1 - hash);
  const std::vector<Place> places = numbers_of(text);
  ASSERT_GT(places.size(), 100u);
  std::mt19937_64 random(15);
  int n[3] = {};
  for (int round = 0; round < 100; ++round) {
    const Place& place = places[random() % places.size()];
    const std::string other = mutated(text.substr(place.at, place.length), random);
    std::string changed = text;
    changed.replace(place.at, place.length, other);
    SCOPED_TRACE("at " + std::to_string(place.at) + ": " + other);
    ++n[static_cast<int>(outcome_of(changed))];
    if (HasFailure()) break;
  }
  // All three happen, or the mutations are no test.
  for (const int count : n) EXPECT_GT(count, 3);
}

// With the hash that a design writes no number of the plant changes unseen.
TEST_P(Mutations, OfThePlantAreSeenByItsHash) {
  const std::string text = to_yaml(gains_);
  const std::size_t plant = text.find("\nplant:");
  std::mt19937_64 random(16);
  int n_changed = 0;
  const std::vector<Place> places = numbers_of(text);
  for (int round = 0; round < 300; ++round) {
    const Place& place = places[random() % places.size()];
    if (place.at < plant) continue;
    const std::string number = text.substr(place.at, place.length);
    std::string other = mutated(number, random);
    if (other == ".nan" || std::strtod(other.c_str(), nullptr) == std::stod(number)) continue;
    std::string changed = text;
    changed.replace(place.at, place.length, other);
    EXPECT_EQ(outcome_of(changed), Outcome::out_of_range) << number << " as " << other;
    ++n_changed;
  }
  EXPECT_GT(n_changed, 50);
}

INSTANTIATE_TEST_SUITE_P(
    Shipped, Mutations,
    testing::Values(Design{"metrology_frame", ""}, Design{"metrology_frame", "force_feedback_8hz"},
                    Design{"metrology_frame", "force_feedback_10khz"},
                    Design{"frame_slow_actuators", ""}, Design{"frame_flexible", ""},
                    Design{"frame_unequal_legs", ""}, Design{"frame_under_gravity", ""}));

}  // namespace
}  // namespace stillframe::controller

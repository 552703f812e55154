#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tests/random_scenes/case.hpp"

namespace stillframe::random_scenes {

/// What a relation found on one scene: its worst value beside the bound there.
struct Finding {
  double value = 0, bound = 1;
  std::string what;  ///< which of the numbers it was
  int compared = 0;  ///< how many numbers it is the worst of
  int unknown = 0;   ///< those of them that the bound says little of: it is above a tenth of them
  std::vector<std::string> skipped{};  ///< what was not compared as it would take too long

  /// Part of the bound that is used up; NaN counts as infinitely much.
  double share() const;
  bool holds() const { return share() <= 1; }
  /// Keeps the worse of the two. size: of the number whose difference the value is; infinite where
  /// it is no difference, or relative.
  void take(double other_value, double other_bound, const std::string& other_what,
            double size = std::numeric_limits<double>::infinity());
};

/// Where `what` would cost so much (in the unit of `most`) that it is not done: notes that, and
/// answers whether it is so. NaN is too much.
bool skips(Finding& finding, const std::string& what, double cost, double most);
/// Where a run was ended after n of `all` samples: notes how much of it is missing, and answers
/// whether too little is left to compare anything.
bool too_short(Finding& finding, const std::string& run, std::int64_t n, std::int64_t all);

/// Something that must hold on every scene of its domain.
struct Relation {
  const char* name;
  const char* bound;  ///< what the bound is and why, in one line
  /// Nothing where the scene is outside the domain; the reason stands in the code. seed: for what
  /// is drawn at random besides the scene.
  std::optional<Finding> (*check)(Case& scene, std::uint64_t seed);
};

const std::vector<Relation>& relations();

}  // namespace stillframe::random_scenes

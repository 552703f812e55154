#include "core/mechanics/load_path.hpp"

#include <cmath>
#include <cstdlib>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"

namespace stillframe {

namespace {

/// A share below 1 in four digits, rounded down: what was not reached is not said to be.
std::string shown_share(double share) {
  const std::string text = formatted("%.4g", share);
  if (std::strtod(text.c_str(), nullptr) <= share) return text;
  const double digit = std::pow(10, std::floor(std::log10(share)) - 3);
  return formatted("%.4g", share - digit);
}

}  // namespace

void refuse_load(const LoadPath& path, const std::string& moved) {
  throw Refusal(
      "no equilibrium found: the loads can be followed up to " + shown_share(path.reached) +
      " of their size" +
      (path.attempts < most_attempts
           ? "; beyond, the configuration collapses (a limit or buckling load) or nothing resists"
           : " in " + std::to_string(most_attempts) +
                 " steps, and are far too large for what has to bear them (a wrong power of "
                 "ten?)") +
      (moved.empty() ? "" : "; there, " + moved));
}

void refuse_any_load(const std::string& unresisted) {
  if (unresisted.empty()) {
    throw Refusal(
        "no equilibrium found: not even a small part of the loads can be balanced, from the scene "
        "as written or near it");
  }
  throw Refusal("no equilibrium found: the scene is a mechanism, nothing resists a motion of " +
                unresisted +
                ", and the loads push it; hold it, give it a stiffness, or write the scene where "
                "it hangs");
}

}  // namespace stillframe

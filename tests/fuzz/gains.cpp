#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/systems/sampled_loop.hpp"
#include "tests/fuzz/decay.hpp"
#include "tests/fuzz/targets.hpp"

namespace stillframe::fuzz {

using controller::Gains;

namespace {

/// A judgement takes the cube of the states.
constexpr Eigen::Index most_states = 24;

bool is_judged_stable(const Gains& gains) {
  try {
    return controller::closed_loop_radius(gains) < largest_stable_radius;
  } catch (const Refusal&) {
    return false;  // a law that cannot be sampled
  }
}

}  // namespace

void gains(std::string_view bytes) {
  try {
    const Gains gains = controller::parse_gains(std::string(bytes), "gains");
    const std::string text = to_yaml(gains);
    require(to_yaml(controller::parse_gains(text, "written")) == text,
            "gains that are written and read are the same");
    if (most_loop_states(gains) > most_states || !is_judged_stable(gains)) return;
    require(decays(gains), "a loop that is accepted decays when it is simulated");
  } catch (const InputError&) {
  }
}

}  // namespace stillframe::fuzz

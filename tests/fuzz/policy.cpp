#include "controller/policy.hpp"

#include "core/errors/input_error.hpp"
#include "tests/fuzz/targets.hpp"

namespace stillframe::fuzz {

void policy(std::string_view bytes) {
  try {
    const controller::Policy policy = controller::parse_policy(std::string(bytes), "policy", 1000);
    require(policy.fade_s >= 0.01 && policy.fade_s <= 60, "a fade is neither a step nor for ever");
    require(policy.hold_periods >= 0 && policy.hold_periods <= 100, "a force is held 100 periods");
    require(policy.ramp_out_s > 0 && policy.ramp_in_s > 0, "ramps have a length");
  } catch (const InputError&) {
  }
}

}  // namespace stillframe::fuzz

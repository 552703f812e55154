#pragma once

#include <algorithm>
#include <string>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// Which load of a model has a geometric stiffness that is not symmetric, in words: what turns with
/// its node, and in space a torque that does not, which does other work on another way.
inline std::string unsymmetric_load(const Model& model) {
  const auto any = [&](const auto& is) {
    return std::any_of(model.turning_loads.begin(), model.turning_loads.end(), is);
  };
  const bool follows = any([](const ModelLoad& load) { return load.follows; });
  const bool dead = any([](const ModelLoad& load) { return !load.follows; });
  const std::string one = "a load follows its node",
                    other = "a torque keeps its direction while its node turns";
  if (follows && dead) return one + " and " + other;
  return dead ? other : one;
}

}  // namespace stillframe

#pragma once

#include <string>

#include "core/mechanics/sparse/reduced_model.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// What a reduced model consists of, and over the band that it is for what it is off by at most: as
/// the key `reduction` of --json, and in words with a table.
Json reduction_json(const ReducedModel& reduced);
std::string reduction_text(const ReducedModel& reduced);

/// What it is off by at most at frequencies (Hz), infinite where that is not known.
Eigen::VectorXd bounds_of(const ReducedModel& reduced, const Eigen::VectorXd& frequencies_hz);

}  // namespace stillframe::tools

#pragma once

#include "core/mechanics/modes.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// For the verbs that answer about an operating point whether or not it is one that a scene stays
/// at: a line of warning to stderr where it is not stable, with what moves. Answers what the key
/// "stable" of their JSON is: true, false, or null where it is not known.
Json warn_unless_stable(const Model& model, const LinearModel& linear);

}  // namespace stillframe::tools

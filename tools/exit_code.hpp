#pragma once

#include "report/verdict/judgement.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

/// What a verb that judged a run ends with.
constexpr int exit_code_of(report::Outcome outcome) {
  return outcome == report::Outcome::failed ? exit_failed : exit_done;
}

}  // namespace stillframe::tools

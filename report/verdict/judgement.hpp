#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace stillframe::report {

/// How a run, or one thing that was asked of it, came out.
enum class Outcome : std::uint8_t { passed, not_judged, failed };

/// The word for it, in texts, tables, badges and JSON alike.
constexpr std::string_view to_text(Outcome outcome) {
  if (outcome == Outcome::passed) return "passed";
  return outcome == Outcome::failed ? "failed" : "not judged";
}

/// What a check looks at.
enum class Subject : std::uint8_t {
  record,      ///< how whole a log is
  effort,      ///< periods in which the loop could not do what its law says
  motion,      ///< what the frame did
  prediction,  ///< how near the measured loop is to the predicted one
};

/// One thing that was asked of a run.
struct Check {
  Subject subject = Subject::record;
  std::string what;   ///< as in "forces limited, active"
  std::string asked;  ///< as in "at most 1 % of the commands"
  std::string found;  ///< as in "99.2 %"; empty: nothing
  Outcome outcome = Outcome::not_judged;
  std::string reason;     ///< one sentence that stands alone
  bool by_scene = false;  ///< the scene asks for it by name
  /// That it passed shows that the loop is sound; else it can only fail.
  bool is_proof = true;
  bool is_needed = false;  ///< where it could not be judged nothing else passes the run
};

/// What comes of all that was asked. Text, JSON, page and exit code take it from here.
struct Judgement {
  Outcome outcome = Outcome::not_judged;
  std::string reason = "Nothing was asked.";  ///< one sentence
  std::vector<Check> checks;
};

/// Whether a figure is at most what is allowed; NaN is not.
constexpr Outcome at_most(double found, double allowed) {
  return found <= allowed ? Outcome::passed : Outcome::failed;
}

/// Failed if any check failed. Passed if none did, all that is needed or that the scene asks for by
/// name could be judged, and at least one check of motion or prediction that is a proof passed: a
/// whole log of a loop that nobody looked at is not judged.
Judgement conclude(std::vector<Check> checks);

}  // namespace stillframe::report

#include "report/verdict/judgement.hpp"

#include <algorithm>

namespace stillframe::report {

namespace {

/// The same sentence with a word about the others that came out so.
std::string with_others(const std::string& sentence, std::int64_t n_others, const char* what) {
  if (n_others == 0) return sentence;
  return sentence + " (" + std::to_string(n_others) + " more " +
         (n_others == 1 ? "check " : "checks ") + what + ".)";
}

}  // namespace

Judgement conclude(std::vector<Check> checks) {
  Judgement judgement{.outcome = Outcome::not_judged, .reason = {}, .checks = std::move(checks)};
  const auto& all = judgement.checks;
  const auto count = [&](auto&& holds) { return std::count_if(all.begin(), all.end(), holds); };
  const auto first = [&](auto&& holds) { return std::find_if(all.begin(), all.end(), holds); };
  const auto failed = [](const Check& c) { return c.outcome == Outcome::failed; };
  const auto of_loop = [](const Check& c) {
    return c.is_proof && (c.subject == Subject::motion || c.subject == Subject::prediction);
  };
  const auto open = [](const Check& c) { return c.outcome == Outcome::not_judged; };
  if (const auto check = first(failed); check != all.end()) {
    judgement.outcome = Outcome::failed;
    judgement.reason = with_others(check->reason, count(failed) - 1, "failed");
    return judgement;
  }
  const auto missed = first([&](const Check& c) { return open(c) && (c.by_scene || c.is_needed); });
  if (missed != all.end()) {
    judgement.reason = missed->reason;
    return judgement;
  }
  const auto n_of_loop =
      count([&](const Check& c) { return of_loop(c) && c.outcome == Outcome::passed; });
  if (n_of_loop == 0) {
    const auto why = first([&](const Check& c) { return open(c) && of_loop(c); });
    judgement.reason = why != all.end() ? why->reason : "Nothing in the logs shows the loop.";
    return judgement;
  }
  judgement.outcome = Outcome::passed;
  const auto n_passed = static_cast<std::int64_t>(all.size()) - count(open);
  judgement.reason = "All " + std::to_string(n_passed) + " checks that could be made passed.";
  return judgement;
}

}  // namespace stillframe::report

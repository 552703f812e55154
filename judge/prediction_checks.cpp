#include "judge/prediction_checks.hpp"

#include <algorithm>

#include "core/errors/formatted.hpp"
#include "core/numerics/worst.hpp"
#include "report/verdict/acceptance.hpp"

namespace stillframe::judge {

using report::Check;
using report::Outcome;
using report::Subject;

namespace {

/// Where the closed loop lies below the open one: known nowhere is not predicted nowhere.
std::string reduction_in_words(const report::IdentificationSummary& id) {
  if (id.n_reduction_frequencies > 0) {
    return formatted(
               "the closed loop lies below the open one at %d of %d frequencies where it is to",
               id.n_closed_below_open, id.n_reduction_frequencies) +
           (id.n_reduction_unknown > 0
                ? formatted(" (not known at %d more)", id.n_reduction_unknown)
                : "");
  }
  if (id.n_reduction_unknown > 0) {
    return formatted(
        "whether the closed loop lies below the open one is known at none of the %d frequencies "
        "above %.3g Hz where it is to",
        id.n_reduction_unknown, id.reduction_above_hz);
  }
  return "the closed loop lies below the open one at none: the prediction is that it does so "
         "nowhere";
}

std::string found_in_words(const report::IdentificationSummary& id) {
  std::string found = formatted("%.3g dB beyond, reduced at ", id.beyond_db);
  if (id.n_reduction_frequencies > 0) {
    found += formatted("%d of %d", id.n_closed_below_open, id.n_reduction_frequencies);
  } else {
    found += id.n_reduction_unknown > 0 ? "none that is known" : "none";
  }
  return found;
}

std::string reason_of(const report::IdentificationSummary& id) {
  if (id.n_compared() == 0) {
    return "No singular value of the loops is known to 1 dB, so that none is compared.";
  }
  const double largest = worst_of(id.open_largest_db, id.closed_largest_db);
  std::string none;
  if (id.n_open_compared == 0 || id.n_closed_compared == 0) {
    none =
        formatted("No singular value of the %s loop is known to 1 dB, so that none is compared. ",
                  id.n_open_compared == 0 ? "passive" : "active");
  }
  return none +
         formatted(
             "%d measured singular values lie within %.3g dB of the prediction, at most %.3g dB "
             "beyond their bands (allowed: %.3g dB), and ",
             id.n_compared(), largest, id.beyond_db, id.allowed_db) +
         reduction_in_words(id) + ".";
}

Check check_of(report::IdentificationSummary id, std::optional<double> prediction_db) {
  if (prediction_db) id.allowed_db = *prediction_db;
  id.forces_unknown = false;  // prediction_checks says so of all
  return {.subject = Subject::prediction,
          .what = "singular values of both loops against the prediction",
          .asked = formatted("within their bands and %.3g dB, reduced above %.3g Hz", id.allowed_db,
                             id.reduction_above_hz),
          .found = found_in_words(id),
          .outcome = id.outcome(),
          .reason = reason_of(id),
          .by_scene = prediction_db.has_value()};
}

/// What a scene asks for by name, of one response.
Check check_of(const report::ResponseSummary& response, double allowed_db) {
  Check check{
      .subject = Subject::prediction,
      .what = response.loop + ", " + response.what + " against the prediction",
      .asked = formatted("within its bands and %.3g dB", allowed_db),
      .found = "",
      .outcome = Outcome::not_judged,
      .reason = "The " + response.loop + " loop, " + response.what + ": " + response.missing + ".",
      .by_scene = true};
  if (response.n_compared > 0) {
    check.found = formatted("%.3g dB beyond", response.beyond_db);
    check.outcome = report::at_most(response.beyond_db, allowed_db);
    check.reason = formatted(
        "The %s loop, %s, lies within %.3g dB of its prediction (at %.4g Hz) in %d singular "
        "values, at most %.3g dB beyond their bands (allowed: %.3g dB).",
        response.loop.c_str(), response.what.c_str(), response.sampled_largest_db,
        response.sampled_at_hz, response.n_compared, response.beyond_db, allowed_db);
  }
  return check;
}

std::string of_broadly(const report::ResponseSummary& response) {
  return response.loop + ", " + response.what + " against the prediction, broadly";
}

/// Why what is asked by default of a response cannot be; empty: it can.
std::string why_not_broadly(const report::ResponseSummary& response) {
  if (response.n_compared == 0) {
    return response.missing.empty() ? "nothing was identified" : response.missing;
  }
  if (response.unmeasured_broadly_db >= report::default_broad_prediction_db) {
    return "as much motion of the floor where no input measures it would be as large a difference";
  }
  return {};
}

/// Whether the same response of the other loop is looked at.
bool other_is_checked(const report::Verdict& verdict, const report::ResponseSummary& response) {
  return std::any_of(verdict.responses.begin(), verdict.responses.end(), [&](const auto& other) {
    return other.loop != response.loop && other.what == response.what && !other.repeats &&
           why_not_broadly(other).empty();
  });
}

/// What is asked of any response of which something is known.
Check default_check_of(const report::ResponseSummary& response) {
  const double allowed_db = report::default_broad_prediction_db;
  const report::Outcome outcome = report::at_most(response.broadly_beyond_db, allowed_db);
  // A tenth of fewer than ten values is none.
  if (outcome == report::Outcome::passed && response.n_compared < 10) {
    return {.subject = Subject::prediction,
            .what = of_broadly(response),
            .asked = formatted("nine in ten values within their bands and %.3g dB", allowed_db),
            .found = formatted("%d values", response.n_compared),
            .outcome = report::Outcome::not_judged,
            .reason = formatted("The %s loop, %s: only %d singular values are known.",
                                response.loop.c_str(), response.what.c_str(), response.n_compared),
            .is_proof = false};
  }
  return {
      .subject = Subject::prediction,
      .what = of_broadly(response),
      .asked = formatted("nine in ten values within their bands and %.3g dB", allowed_db),
      .found = formatted("%.3g dB beyond", response.broadly_beyond_db),
      .outcome = outcome,
      .reason =
          outcome == Outcome::passed
              ? formatted("The %s loop, %s, is broadly the predicted one: nine in ten of the %d "
                          "singular values that are known lie at most %.3g dB beyond their bands "
                          "(allowed: %.3g dB).",
                          response.loop.c_str(), response.what.c_str(), response.n_compared,
                          response.broadly_beyond_db, allowed_db)
              : formatted("The %s loop, %s, is not the predicted one: a tenth of the %d singular "
                          "values that are known lie %.3g dB or more beyond their bands (allowed: "
                          "%.3g dB).",
                          response.loop.c_str(), response.what.c_str(), response.n_compared,
                          response.broadly_beyond_db, allowed_db),
      .is_proof = false};
}

/// Of all that was or should have been compared, whatever made a difference.
std::vector<Check> comparisons(const RunAnalyses& runs, const report::Verdict& verdict,
                               std::optional<double> prediction_db) {
  std::vector<Check> checks;
  if (verdict.identification) checks.push_back(check_of(*verdict.identification, prediction_db));
  if (prediction_db) {
    for (const report::ResponseSummary& response : verdict.responses) {
      if (response.repeats) continue;
      checks.push_back(check_of(response, *prediction_db));
    }
  }
  if (!checks.empty()) return checks;
  for (const report::ResponseSummary& response : verdict.responses) {
    if (response.repeats) continue;
    const std::string why = why_not_broadly(response);
    if (why.empty()) checks.push_back(default_check_of(response));
    // What neither loop shows is in the table of responses.
    if (!why.empty() && other_is_checked(verdict, response)) {
      checks.push_back(
          {.subject = Subject::prediction,
           .what = of_broadly(response),
           .asked = formatted("nine in ten values within their bands and %.3g dB",
                              report::default_broad_prediction_db),
           .found = "",
           .outcome = Outcome::not_judged,
           .reason = "The " + response.loop + " loop, " + response.what +
                     ", is not set against its prediction, which the other one is: " + why + ".",
           .is_proof = false});
    }
  }
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (!*run || !(*run)->run.multisine || !(*run)->matrix) continue;
    const JudgedResponse& matrix = *(*run)->matrix;
    const std::string& why =
        matrix.measured.missing.empty() ? matrix.unpredicted : matrix.measured.missing;
    checks.push_back({.subject = Subject::prediction,
                      .what = "multisine, " + (*run)->data.scan.info.loop,
                      .asked = "identified",
                      .found = "",
                      .outcome = Outcome::not_judged,
                      .reason = "The multisine of the " + (*run)->data.scan.info.loop +
                                " run shows nothing of the loop: " +
                                (why.empty() ? "the other loop did not run on it" : why) + "."});
  }
  return checks;
}

}  // namespace

std::string forces_in_doubt(const report::Verdict& verdict) {
  if (verdict.forces_unknown.empty()) return {};
  return "forces act on the frame besides the floor and may be the difference (what they do is not "
         "known: " +
         verdict.forces_unknown + ")";
}

std::vector<Check> prediction_checks(const RunAnalyses& runs, const report::Verdict& verdict,
                                     std::optional<double> prediction_db) {
  std::vector<Check> checks = comparisons(runs, verdict, prediction_db);
  const std::string doubt = forces_in_doubt(verdict);
  for (Check& check : checks) {
    // What cannot be taken off may be taken for the floor's doing, and by any number of dB.
    if (doubt.empty() || check.outcome != Outcome::failed) continue;
    check.outcome = Outcome::not_judged;
    check.is_needed = true;
    check.reason.pop_back();
    check.reason += ", but " + doubt + ".";
  }
  return checks;
}

}  // namespace stillframe::judge

#include "tools/analysis/prediction_checks.hpp"

#include "core/worst.hpp"
#include "report/table.hpp"
#include "report/verdict/acceptance.hpp"

namespace stillframe::tools {

using report::cell;
using report::Check;
using report::Outcome;
using report::Subject;

namespace {

Check check_of(report::IdentificationSummary id, std::optional<double> prediction_db) {
  if (prediction_db) id.allowed_db = *prediction_db;
  const double largest = worst_of(id.open_largest_db, id.closed_largest_db);
  const bool reduces = id.n_reduction_frequencies > 0;
  const std::string below =
      reduces ? cell("%d of %d", id.n_closed_below_open, id.n_reduction_frequencies) : "none";
  return {
      .subject = Subject::prediction,
      .what = "singular values of both loops against the prediction",
      .asked = cell("within their bands and %.3g dB, reduced above %.3g Hz", id.allowed_db,
                    id.reduction_above_hz),
      .found = cell("%.3g dB beyond, reduced at ", id.beyond_db) + below,
      .outcome = id.n_compared == 0 ? Outcome::not_judged
                 : id.pass()        ? Outcome::passed
                                    : Outcome::failed,
      .reason = id.n_compared == 0
                    ? "No singular value of the loops is known to 1 dB, so that none is compared."
                    : cell("%d measured singular values lie within %.3g dB of the prediction, at "
                           "most %.3g dB beyond their bands (allowed: %.3g dB), and the closed "
                           "loop lies below the open one at ",
                           id.n_compared, largest, id.beyond_db, id.allowed_db) +
                          below +
                          (reduces ? " frequencies where it is to."
                                   : ": the prediction is that it does so nowhere."),
      .by_scene = prediction_db.has_value()};
}

/// What a scene asks for by name, of one response.
Check check_of(const report::ResponseSummary& response, double allowed_db) {
  Check check{
      .subject = Subject::prediction,
      .what = response.loop + ", " + response.what + " against the prediction",
      .asked = cell("within its bands and %.3g dB", allowed_db),
      .found = "",
      .outcome = Outcome::not_judged,
      .reason = "The " + response.loop + " loop, " + response.what + ": " + response.missing + ".",
      .by_scene = true};
  if (response.n_compared > 0) {
    check.found = cell("%.3g dB beyond", response.beyond_db);
    check.outcome = report::at_most(response.beyond_db, allowed_db);
    check.reason = cell(
        "The %s loop, %s, lies within %.3g dB of its prediction (at %.4g Hz) in %d singular "
        "values, at most %.3g dB beyond their bands (allowed: %.3g dB).",
        response.loop.c_str(), response.what.c_str(), response.sampled_largest_db,
        response.sampled_at_hz, response.n_compared, response.beyond_db, allowed_db);
  }
  return check;
}

/// What is asked of any response of which something is known.
Check default_check_of(const report::ResponseSummary& response) {
  const double allowed_db = report::default_broad_prediction_db;
  const report::Outcome outcome = report::at_most(response.broadly_beyond_db, allowed_db);
  return {
      .subject = Subject::prediction,
      .what = response.loop + ", " + response.what + " against the prediction, broadly",
      .asked = cell("nine in ten values within their bands and %.3g dB", allowed_db),
      .found = cell("%.3g dB beyond", response.broadly_beyond_db),
      .outcome = outcome,
      .reason = outcome == Outcome::passed
                    ? cell("The %s loop, %s, is broadly the predicted one: nine in ten of the %d "
                           "singular values that are known lie at most %.3g dB beyond their bands "
                           "(allowed: %.3g dB).",
                           response.loop.c_str(), response.what.c_str(), response.n_compared,
                           response.broadly_beyond_db, allowed_db)
                    : cell("The %s loop, %s, is not the predicted one: a tenth of the %d singular "
                           "values that are known lie %.3g dB or more beyond their bands (allowed: "
                           "%.3g dB).",
                           response.loop.c_str(), response.what.c_str(), response.n_compared,
                           response.broadly_beyond_db, allowed_db),
      .is_proof = false};
}

}  // namespace

std::vector<Check> prediction_checks(const RunAnalyses& runs, const report::Verdict& verdict,
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
    if (response.n_compared == 0 || response.repeats) continue;
    // What no input measures may have done as much.
    if (response.unmeasured_broadly_db >= report::default_broad_prediction_db) continue;
    checks.push_back(default_check_of(response));
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

}  // namespace stillframe::tools

#include "tools/analysis/prediction_checks.hpp"

#include <cmath>
#include <limits>

#include "core/worst.hpp"
#include "report/table.hpp"
#include "report/verdict/motion_level.hpp"

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
        "The %s loop lies within %.3g dB of its prediction (at %.4g Hz) in %d singular values, at "
        "most %.3g dB beyond their bands (allowed: %.3g dB).",
        response.loop.c_str(), response.sampled_largest_db, response.sampled_at_hz,
        response.n_compared, response.beyond_db, allowed_db);
  }
  return check;
}

}  // namespace

std::vector<Check> prediction_checks(const RunAnalyses& runs, const report::Verdict& verdict,
                                     std::optional<double> prediction_db) {
  std::vector<Check> checks;
  if (verdict.identification) checks.push_back(check_of(*verdict.identification, prediction_db));
  if (prediction_db) {
    for (const report::ResponseSummary& response : verdict.responses) {
      checks.push_back(check_of(response, *prediction_db));
    }
  }
  if (!checks.empty()) return checks;
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

namespace {

/// Of the lines of two responses in a range: what an output makes of the inputs, with control over
/// without, and by how much noise may have changed that.
struct MultisineGain {
  double found = 0, least = 0, most = 0;
  Eigen::Index n_lines = 0;
};

MultisineGain gain_of(const report::FrequencyResponse& open,
                      const report::FrequencyResponse& closed, Eigen::Index output, double from_hz,
                      double to_hz) {
  MultisineGain gain;
  double power[2] = {0, 0}, noise[2] = {0, 0};
  for (Eigen::Index l = 0; l < open.n_frequencies(); ++l) {
    const auto at = static_cast<std::size_t>(l);
    const double f = open.frequencies_hz[at];
    if (f < from_hz || f > to_hz) continue;
    ++gain.n_lines;
    for (const int i : {0, 1}) {
      const report::FrequencyResponse& response = i == 0 ? open : closed;
      power[i] += response.T[at].row(output).squaredNorm();
      noise[i] += std::real(response.noise[at](output, output)) *
                  std::real(response.input_weight[at].trace());
    }
  }
  const double passive = std::sqrt(power[0]), active = std::sqrt(power[1]);
  // Twice the standard deviation, as a 95 % band has.
  const double of_passive = 2 * std::sqrt(noise[0]), of_active = 2 * std::sqrt(noise[1]);
  gain.found = active / passive;
  gain.least = (active - of_active) / (passive + of_passive);
  gain.most = passive > of_passive ? (active + of_active) / (passive - of_passive)
                                   : std::numeric_limits<double>::infinity();
  return gain;
}

}  // namespace

std::optional<Check> multisine_motion(const RunAnalyses& runs) {
  if (!runs.passive || !runs.active || !runs.any().run.multisine || !runs.same_floor() ||
      !runs.passive->matrix || !runs.active->matrix) {
    return std::nullopt;
  }
  const auto &open = runs.passive->matrix->measured, &closed = runs.active->matrix->measured;
  if (!open.response || !closed.response ||
      open.response->frequencies_hz != closed.response->frequencies_hz) {
    return std::nullopt;
  }
  double from_hz = report::lowest_level_hz, to_hz = report::highest_level_hz;
  std::optional<MultisineGain> worst;
  std::string of;
  for (int attempt = 0; attempt < 2 && !worst; ++attempt) {
    for (std::size_t i = 0; i < open.signals.outputs.size(); ++i) {
      const auto gain =
          gain_of(*open.response, *closed.response, static_cast<Eigen::Index>(i), from_hz, to_hz);
      if (gain.n_lines == 0 || (worst && gain.found <= worst->found)) continue;
      worst = gain;
      of = open.signals.outputs[i];
    }
    if (worst) break;
    from_hz = 0;
    to_hz = std::numeric_limits<double>::infinity();
  }
  if (!worst) return std::nullopt;
  const bool all = from_hz == 0;
  const std::string range = all ? "all " + std::to_string(worst->n_lines) + " lines"
                                : cell("%g to %g Hz", from_hz, to_hz);
  Check check{
      .subject = Subject::motion,
      .what = "output " + of + ", active to passive frame, lines of the multisine, " + range,
      .asked = "at most 1",
      .found = cell("%.4g", worst->found),
      .outcome = report::at_most(worst->found, 1),
      .reason = "Output " + of + ": the active frame makes " + cell("%.4g", worst->found) +
                " times as much of the multisine as the passive one (" + range + "), allowed is 1.",
      .by_scene = false};
  if (worst->found <= 1 ? worst->most > 1 : worst->least <= 1) {
    check.outcome = Outcome::not_judged;
    check.reason = "Output " + of + ": the active frame makes " + cell("%.4g", worst->found) +
                   " times as much of the multisine as the passive one (" + range +
                   "), which noise leaves known from " + cell("%.3g", worst->least) + " to " +
                   cell("%.3g", worst->most) + " only.";
  }
  return check;
}

}  // namespace stillframe::tools

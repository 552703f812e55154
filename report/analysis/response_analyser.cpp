#include "report/analysis/response_analyser.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "report/identification/confidence.hpp"
#include "report/identification/input_noise.hpp"
#include "report/identification/multisine.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;

ResponseAnalyser::ResponseAnalyser(ResponseSignals signals, const MultisinePlan& plan)
    : method_(Lines{}) {
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  const Index rows = plan.n_samples() + 1;
  method_ =
      Lines{plan, MatrixXd::Constant(rows, static_cast<Index>(signals.inputs.size()), missing),
            MatrixXd::Constant(rows, static_cast<Index>(signals.outputs.size()), missing)};
  result_.signals = std::move(signals);
  result_.method = "multisine";
}

namespace {

/// With a model, what it leaves of the outputs and of n channels of the floor stands before the
/// outputs.
BroadbandPlan with_residual(BroadbandPlan plan, bool model, Index n) {
  if (model) plan.n_outputs += plan.n_outputs + n;
  return plan;
}

/// Whether channels of the floor are the motion that the model follows.
struct InputDifference {
  std::vector<bool> shows;  ///< at a frequency, beyond its band and what is allowed
  std::string why;          ///< they are not, if that shows at more than half of the frequencies
};

/// residual: as in about_model, with what is left of all channels behind that of the n_y outputs.
InputDifference input_difference(const FrequencyResponse& residual, Index n_y,
                                 const std::vector<std::string>& channels) {
  const auto n = static_cast<Index>(channels.size());
  const double allowed = std::pow(10, largest_input_difference_db / 20) - 1;
  InputDifference result{std::vector<bool>(residual.T.size(), false), {}};
  Index n_known = 0, n_shown = 0;
  double largest = 0;
  for (Index l = 0; l < residual.n_frequencies(); ++l) {
    if (!(residual.input_condition(l) < largest_shown_condition)) continue;
    ++n_known;
    const auto at = static_cast<std::size_t>(l);
    const MatrixXd size = residual.T[at].middleRows(n_y, n).cwiseAbs();
    const MatrixXd beyond = size - entry_radii(residual, l, 0.95).middleRows(n_y, n);
    Index channel = 0, by = 0;
    if (!(beyond.maxCoeff(&channel, &by) > allowed)) continue;
    ++n_shown;
    result.shows[at] = true;
    if (size(channel, by) <= largest) continue;
    largest = size(channel, by);
    result.why = channels[static_cast<std::size_t>(channel)] +
                 " is not what the inputs say of a floor that does not turn (the floor does, or "
                 "its feet move each on their own, or that channel is of another one): " +
                 formatted("at %.4g Hz it differs from it by %.3g %%, ",
                           residual.frequencies_hz[at], 100 * largest) +
                 formatted("allowed are %.2g %% beyond its band", 100 * allowed);
  }
  if (2 * n_shown <= n_known) result.why.clear();
  return result;
}

}  // namespace

ResponseAnalyser::ResponseAnalyser(ResponseSignals signals, const BroadbandPlan& plan,
                                   std::vector<Eigen::MatrixXcd> model,
                                   std::vector<std::string> further)
    : model_(std::move(model)),
      checked_(signals.inputs),
      density_(2 / plan.sample_rate_hz),
      input_noise_(plan.input_noise),
      method_(std::in_place_type<LocalPolynomial>,
              with_residual(plan, !model_.empty(), plan.n_inputs + std::ssize(further))) {
  std::move(further.begin(), further.end(), std::back_inserter(checked_));
  result_.signals = std::move(signals);
  result_.method = "broadband";
}

void ResponseAnalyser::add(std::int64_t first_seq, const MatrixXd& inputs, const MatrixXd& outputs,
                           const MatrixXd& predicted, const MatrixXd& strayed) {
  if (auto* broadband = std::get_if<LocalPolynomial>(&method_)) {
    if (model_.empty()) return broadband->add(first_seq, inputs, outputs);
    MatrixXd all = MatrixXd::Zero(outputs.rows(), 2 * outputs.cols() + std::ssize(checked_));
    all.leftCols(outputs.cols()) = outputs - predicted;
    if (strayed.size() > 0) all.middleCols(outputs.cols(), strayed.cols()) = strayed;
    all.rightCols(outputs.cols()) = outputs;
    return broadband->add(first_seq, inputs, all);
  }
  auto& lines = std::get<Lines>(method_);
  const Index n = std::min<Index>(inputs.rows(), lines.inputs.rows() - first_seq);
  if (first_seq < 0 || n <= 0) return;
  lines.inputs.middleRows(first_seq, n) = inputs.topRows(n);
  lines.outputs.middleRows(first_seq, n) = outputs.topRows(n);
}

IdentifiedResponse ResponseAnalyser::finish() {
  IdentifiedResponse result = result_;
  if (auto* lines = std::get_if<Lines>(&method_)) {
    result.n_segments = lines->plan.n_blocks;
    result.resolution_hz = 4 / lines->plan.window_s;
    try {
      result.n_filled = fill_lost_rows(lines->plan, lines->inputs, lines->outputs);
      result.response = identify(lines->plan, lines->inputs, lines->outputs);
    } catch (const InputError& error) {
      result.missing = error.what();
    }
    return result;
  }
  auto& broadband = std::get<LocalPolynomial>(method_);
  broadband.finish();
  result.n_filled = broadband.n_filled();
  result.n_left_out = broadband.n_left_out();
  result.n_segments = broadband.n_segments();
  result.resolution_hz = broadband.half_width_hz();
  result.missing = broadband.missing(result.signals.inputs);
  if (!result.missing.empty()) return result;
  FrequencyResponse response = broadband.estimate();
  std::vector<bool> other_motion(response.T.size(), false);
  if (!model_.empty()) {
    InputDifference difference =
        input_difference(response, std::ssize(result.signals.outputs), checked_);
    result.missing = difference.why;
    if (!result.missing.empty()) return result;
    other_motion = std::move(difference.shows);
    response = about_model(response, model_, density_);
  }
  find_input_share(response, input_noise_, 2 / density_);
  const double best = response.input_condition.minCoeff();
  if (!(best < largest_shown_condition)) {
    result.missing =
        "the inputs do not move independently: some are always the same combination of others "
        "(condition " +
        formatted("%.1e", best) + " at best)";
    return result;
  }
  for (Eigen::Index l = 0; l < response.n_frequencies(); ++l) {
    const auto at = static_cast<std::size_t>(l);
    if (response.input_condition(l) < largest_shown_condition && !other_motion[at]) continue;
    response.T[at].setConstant(std::numeric_limits<double>::quiet_NaN());
    response.singular_values.row(l).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  result.response = std::move(response);
  return result;
}

}  // namespace stillframe::report

#include "report/analysis/response_analyser.hpp"

#include <algorithm>
#include <limits>

#include "core/yaml/input_error.hpp"
#include "report/identification/multisine.hpp"
#include "report/table.hpp"

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

/// With a model, what it leaves of the outputs stands before the outputs.
BroadbandPlan with_residual(BroadbandPlan plan, bool model) {
  if (model) plan.n_outputs *= 2;
  return plan;
}

}  // namespace

ResponseAnalyser::ResponseAnalyser(ResponseSignals signals, const BroadbandPlan& plan,
                                   std::vector<Eigen::MatrixXcd> model)
    : model_(std::move(model)),
      density_(2 / plan.sample_rate_hz),
      method_(std::in_place_type<LocalPolynomial>, with_residual(plan, !model_.empty())) {
  result_.signals = std::move(signals);
  result_.method = "broadband";
}

void ResponseAnalyser::add(std::int64_t first_seq, const MatrixXd& inputs, const MatrixXd& outputs,
                           const MatrixXd& predicted) {
  if (auto* broadband = std::get_if<LocalPolynomial>(&method_)) {
    if (model_.empty()) return broadband->add(first_seq, inputs, outputs);
    MatrixXd both(outputs.rows(), 2 * outputs.cols());
    both << outputs - predicted, outputs;
    return broadband->add(first_seq, inputs, both);
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
  result.missing = broadband.missing();
  if (!result.missing.empty()) return result;
  FrequencyResponse response = broadband.estimate();
  if (!model_.empty()) response = about_model(response, model_, density_);
  const double best = response.input_condition.minCoeff();
  if (!(best < largest_shown_condition)) {
    result.missing =
        "the inputs do not move independently: some are always the same combination of others "
        "(condition " +
        cell("%.1e", best) + " at best)";
    return result;
  }
  for (Eigen::Index l = 0; l < response.n_frequencies(); ++l) {
    if (response.input_condition(l) < largest_shown_condition) continue;
    response.T[static_cast<std::size_t>(l)].setConstant(std::numeric_limits<double>::quiet_NaN());
    response.singular_values.row(l).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  result.response = std::move(response);
  return result;
}

}  // namespace stillframe::report

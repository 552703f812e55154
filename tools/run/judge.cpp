#include "tools/run/judge.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>

#include "core/errors/input_error.hpp"
#include "judge/loop_comparison.hpp"
#include "judge/loop_peaks.hpp"
#include "judge/verdict_of.hpp"
#include "report/plots/plots.hpp"

namespace stillframe::tools {

namespace {

/// What is known of them: a value whose band is wider than 1 dB to a side is no measurement.
report::MeasuredValues measured_of(const std::optional<judge::RunAnalysis>& run) {
  if (!run || !run->matrix || !run->matrix->measured.response) return {};
  const auto& response = *run->matrix->measured.response;
  const report::Bands& bands = run->matrix->bands;
  const double widest = std::pow(10, 2.0 / 20);
  report::MeasuredValues known;
  std::vector<Eigen::Index> rows;
  Eigen::MatrixXd values = response.singular_values;
  for (Eigen::Index l = 0; l < values.rows(); ++l) {
    for (Eigen::Index i = 0; i < values.cols(); ++i) {
      if (!(bands.upper(l, i) <= widest * bands.lower(l, i))) {
        values(l, i) = std::numeric_limits<double>::quiet_NaN();
      }
    }
    if (values.row(l).array().isNaN().all()) continue;
    known.frequencies_hz.push_back(response.frequencies_hz[static_cast<std::size_t>(l)]);
    rows.push_back(l);
  }
  known.singular_values = values(rows, Eigen::all);
  return known;
}

void plot_singular_values(const judge::LoopDesign& design, const judge::RunAnalyses& runs,
                          const RunDirectory& directory) {
  report::SingularValuePlot picture;
  picture.title = design.scene.title;
  picture.frequencies_hz = judge::picture_frequencies(
      design, judge::axis_of(design, design.scene.controller->target_hz));
  picture.open_predicted = report::predicted_singular_values(design.open, picture.frequencies_hz);
  picture.closed_predicted =
      report::predicted_singular_values(design.closed, picture.frequencies_hz);
  picture.target_frequency_hz = design.scene.controller->lowest_target_hz();
  picture.target_damping = design.scene.controller->damping_ratio.front();
  picture.open_measured = measured_of(runs.passive);
  picture.closed_measured = measured_of(runs.active);
  if (picture.open_measured.frequencies_hz.empty() &&
      picture.closed_measured.frequencies_hz.empty()) {
    picture.title += " (predicted only: this floor shows no singular values to 1 dB)";
  }
  report::plot_singular_values(picture, directory / "singular_values.png");
}

void plot_errors(const judge::LoopDesign& design, const judge::RunAnalyses& runs,
                 const RunDirectory& directory) {
  const auto& open = runs.passive->matrix->errors;
  const auto& closed = runs.active->matrix->errors;
  report::plot_differences(
      {.title = design.scene.title,
       .frequencies_hz = runs.active->matrix->measured.response->frequencies_hz,
       .open_db = open->sampled.difference_db,
       .closed_db = closed->sampled.difference_db,
       .allowed_db = open->sampled.tolerance_db},
      directory / "prediction_error.png");
}

/// Time, smallest and largest value of the parts of an envelope.
Eigen::MatrixXd rows_of(const page::Envelope& envelope) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(envelope.lower.size()), 3);
  const double part_s = envelope.sample_time_s * static_cast<double>(envelope.part_samples);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    rows.row(i) << envelope.first_time_s + part_s * static_cast<double>(i),
        static_cast<double>(envelope.lower[at]), static_cast<double>(envelope.upper[at]);
  }
  return rows;
}

void plot_motion(const judge::LoopDesign& design, const judge::RunAnalyses& runs,
                 const RunDirectory& directory) {
  report::HistoryPlot histories{.title = design.scene.title, .axes = {}};
  report::OctavePlot octaves{.title = design.scene.title, .axes = {}};
  for (const judge::AxisPair& axis : runs.axes()) {
    report::AxisHistory history{axis.name, rows_of(axis.floor().envelope), {}, {}};
    report::AxisBands bands{axis.name, axis.floor().third_octaves, {}, {}};
    if (axis.passive != nullptr) {
      history.passive = rows_of(axis.passive->frame.envelope);
      bands.passive = axis.passive->frame.third_octaves;
    }
    if (axis.active != nullptr) {
      history.active = rows_of(axis.active->frame.envelope);
      bands.active = axis.active->frame.third_octaves;
    }
    histories.axes.push_back(std::move(history));
    octaves.axes.push_back(std::move(bands));
  }
  if (histories.axes.empty()) return;
  report::plot_histories(histories, directory / "accelerations.png");
  report::plot_third_octaves(octaves, directory / "third_octaves.png");
}

}  // namespace

report::Verdict judge(const judge::LoopDesign& design, const judge::RunAnalyses& runs,
                      const RunDirectory& directory) {
  report::Verdict verdict = judge::verdict_of(runs);
  try {
    if (verdict.identification) {
      plot_errors(design, runs, directory);
    } else if (!runs.any().run.multisine) {
      plot_motion(design, runs, directory);
    }
    plot_singular_values(design, runs, directory);
  } catch (const InputError& error) {
    // The logs, and what they are judged by, do not need them.
    std::cerr << "stillframe: warning: " << error.what() << "; the run goes without its plots\n";
  }
  return verdict;
}

}  // namespace stillframe::tools

#include "judge/page_figures.hpp"

#include <algorithm>
#include <cmath>

#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/loop_comparison.hpp"
#include "judge/loop_peaks.hpp"
#include "judge/loop_target.hpp"
#include "plant_sim/floor/density.hpp"
#include "report/identification/confidence.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::vector<double> list_of(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

page::MeasuredValues measured_matrix(const JudgedResponse& judged) {
  const report::FrequencyResponse& response = *judged.measured.response;
  page::MeasuredValues values;
  values.frequencies_hz = response.frequencies_hz;
  values.values = response.singular_values;
  values.lower = judged.bands.lower;
  values.upper = judged.bands.upper;
  values.coherence = list_of(response.directional_coherence.rowwise().minCoeff());
  if (judged.errors) {
    values.difference_db = judged.errors->sampled.difference_db;
  }
  return values;
}

/// The model that predicts: the active run's, whose gains are the loop's.
const LoopDesign* design_of(const RunAnalyses& runs) {
  const auto& design = runs.any().run.design;
  return design ? &*design : nullptr;
}

std::vector<double> target_curve(const LoopTarget& target, const std::vector<double>& grid) {
  std::vector<double> curve;
  for (const double f : grid) {
    const std::complex<double> s(0, f / target.frequency_hz);
    curve.push_back(std::abs(1.0 / (s * s + 2 * target.damping_ratio * s + 1.0)));
  }
  return curve;
}

page::Curve curve_of(const std::vector<double>& frequencies_hz, const Eigen::VectorXd& values) {
  return {.name = "", .frequencies_hz = frequencies_hz, .values = list_of(values)};
}

std::vector<double> psd_frequencies(const report::Psd& psd) {
  std::vector<double> frequencies;
  for (Index k = 0; k < psd.density.size(); ++k) frequencies.push_back(psd.frequency_hz(k));
  return frequencies;
}

/// As many points as a picture shows: steps of a hundredth of the frequency.
page::Curve cumulative_curve(const report::Psd& power) {
  const Eigen::VectorXd rms = report::cumulative_rms(power);
  page::Curve curve{.name = "", .frequencies_hz = {}, .values = {}};
  for (Index k = 0; k < rms.size(); k += std::max<Index>(1, k / 100)) {
    curve.frequencies_hz.push_back(power.frequency_hz(k));
    curve.values.push_back(rms(k));
  }
  curve.frequencies_hz.push_back(power.frequency_hz(rms.size() - 1));
  curve.values.push_back(rms(rms.size() - 1));
  return curve;
}

void add_spectra(const report::SignalAnalysis& signal, page::Curve page::SignalCurves::*member,
                 page::SpectraAxis& axis) {
  if (signal.density.density.size() == 0) return;
  page::Curve& bands = axis.third_octaves.*member;
  for (const report::OctaveBand& band : report::third_octave_bands()) {
    const double velocity = signal.third_octaves(static_cast<Index>(bands.values.size()));
    if (std::isnan(velocity)) break;  // this one and those above it were not observed
    bands.frequencies_hz.push_back(band.nominal_hz);
    bands.values.push_back(velocity);
  }
  axis.density.*member = curve_of(psd_frequencies(signal.density), signal.density.density);
  axis.cumulative_rms.*member = cumulative_curve(signal.power);
}

page::Curve noise_model(const std::string& name, bool high) {
  page::Curve curve{.name = name, .frequencies_hz = {}, .values = {}};
  for (const double f : list_of(logarithmic_frequencies(0.05, 9.99, 60))) {
    curve.frequencies_hz.push_back(f);
    curve.values.push_back(floor::density_at(floor::PetersonDensity{high}, f));
  }
  return curve;
}

}  // namespace

std::optional<page::SingularValueFigure> singular_value_figure(const RunAnalyses& runs) {
  page::SingularValueFigure figure;
  bool any = false;
  if (const LoopDesign* design = design_of(runs)) {
    figure.frequencies_hz = picture_frequencies(*design, axis_of(*design));
    figure.open = report::predicted_singular_values(design->open, figure.frequencies_hz);
    figure.closed = report::predicted_singular_values(design->closed, figure.frequencies_hz);
    std::vector<Eigen::MatrixXcd> continuous;
    for (const double f : figure.frequencies_hz) {
      continuous.push_back(design->loop.closed({0, two_pi * f}));
    }
    figure.closed_continuous = report::singular_values(continuous);
    if (const auto target = target_of(*design)) {
      figure.target = target_curve(*target, figure.frequencies_hz);
    }
    any = true;
  }
  const auto measure = [&](const std::optional<RunAnalysis>& run, page::MeasuredValues& values) {
    if (!run || !run->matrix || !run->matrix->measured.response) return;
    values = measured_matrix(*run->matrix);
    if (run->matrix->errors) figure.allowed_db = run->matrix->errors->sampled.tolerance_db;
    any = true;
  };
  measure(runs.passive, figure.open_measured);
  measure(runs.active, figure.closed_measured);
  if (!any) return std::nullopt;
  return figure;
}

std::vector<page::TransmissibilityAxis> transmissibility_figures(const RunAnalyses& runs,
                                                                 const report::Verdict& verdict) {
  std::vector<page::TransmissibilityAxis> figures;
  // A run on a multisine has no axes.
  const auto& any = runs.any().data.axes.empty() && runs.passive ? *runs.passive : runs.any();
  if (any.data.axes.empty()) return figures;
  std::vector<double> grid;
  std::optional<PredictedResponse> passive, active;
  if (any.axes && any.run.design) {
    try {
      grid = picture_frequencies(*any.run.design, axis_of(*any.run.design));
      const ResponsePrediction prediction(*any.run.design, any.axes->measured.signals,
                                          any.run.nodes);
      passive = prediction.at(grid, false);
      active = prediction.at(grid, true);
    } catch (const std::exception&) {
      // The verdict says why under `missing`.
    }
  }
  for (std::size_t a = 0; a < any.data.axes.size(); ++a) {
    const report::AxisSignals& axes = any.data.axis_signals;
    const Index i = axes.output[a];
    const Eigen::VectorXd along = axes.along.row(static_cast<Index>(a)).transpose();
    page::TransmissibilityAxis figure;
    figure.axis = any.data.axes[a].name;
    if (passive) {
      figure.frequencies_hz = grid;
      for (std::size_t l = 0; l < grid.size(); ++l) {
        figure.passive.push_back(std::abs((passive->sampled[l].row(i) * along).value()));
        figure.active.push_back(std::abs((active->sampled[l].row(i) * along).value()));
      }
    }
    bool drawn = passive.has_value();
    for (const report::Transmissibility& t : verdict.transmissibility) {
      if (t.axis != figure.axis) continue;
      auto& values = t.loop == "active" ? figure.active_measured : figure.passive_measured;
      const auto column = [](const std::vector<double>& list) -> MatrixXd {
        return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Index>(list.size()));
      };
      values.frequencies_hz = t.frequencies_hz;
      values.values = column(t.value);
      values.lower = column(t.lower);
      values.upper = column(t.upper);
      values.coherence = t.coherence;
      drawn = true;
    }
    if (drawn) figures.push_back(std::move(figure));
  }
  return figures;
}

std::vector<page::HistoryAxis> histories_of(const RunAnalyses& runs) {
  std::vector<page::HistoryAxis> histories;
  for (const AxisPair& axis : runs.axes()) {
    page::HistoryAxis history;
    history.axis = axis.title(runs);
    history.floor = axis.floor().envelope;
    if (axis.passive != nullptr) history.passive = axis.passive->frame.envelope;
    if (axis.active != nullptr) history.active = axis.active->frame.envelope;
    histories.push_back(std::move(history));
  }
  return histories;
}

std::vector<page::LegHistory> leg_forces_of(const RunAnalyses& runs) {
  std::vector<page::LegHistory> forces;
  if (!runs.active) return forces;
  std::optional<double> limit;
  if (runs.active->run.design) limit = runs.active->run.design->gains.force_limit_n;
  for (const report::LegAnalysis& leg : runs.active->data.legs) {
    forces.push_back({.leg = leg.name, .force = leg.applied, .limit_n = limit});
  }
  return forces;
}

page::SpectraFigures spectra_of(const RunAnalyses& runs) {
  page::SpectraFigures figures;
  for (const AxisPair& pair : runs.axes()) {
    page::SpectraAxis axis;
    axis.axis = pair.title(runs);
    add_spectra(pair.floor(), &page::SignalCurves::floor, axis);
    if (pair.passive != nullptr) {
      add_spectra(pair.passive->frame, &page::SignalCurves::passive, axis);
    }
    if (pair.active != nullptr) add_spectra(pair.active->frame, &page::SignalCurves::active, axis);
    figures.axes.push_back(std::move(axis));
  }
  if (figures.axes.empty()) return figures;
  for (const report::VibrationCriterion& criterion : report::vibration_criteria()) {
    page::Curve curve{.name = criterion.name, .frequencies_hz = {}, .values = {}};
    for (const report::OctaveBand& band : report::third_octave_bands()) {
      if (!criterion.applies(band.centre_hz)) continue;
      curve.frequencies_hz.push_back(band.nominal_hz);
      curve.values.push_back(criterion.limit(band.centre_hz));
    }
    figures.criteria.push_back(std::move(curve));
  }
  figures.models = {noise_model("NLNM", false), noise_model("NHNM", true)};
  return figures;
}

std::vector<page::Histogram> histograms_of(const RunAnalyses& runs) {
  std::vector<page::Histogram> histograms;
  const auto add = [&](const std::string& name, const report::DurationHistogram& histogram) {
    if (histogram.count() == 0) return;
    // Without the empty bins at both ends.
    const auto& counts = histogram.counts();
    const auto filled = [](std::int64_t count) { return count > 0; };
    const auto first = std::find_if(counts.begin(), counts.end(), filled) - counts.begin();
    const auto behind = counts.rend() - std::find_if(counts.rbegin(), counts.rend(), filled);
    const auto& edges = histogram.edges_us();
    histograms.push_back({.name = name,
                          .edges_us = {edges.begin() + first, edges.begin() + behind + 1},
                          .counts = {counts.begin() + first, counts.begin() + behind}});
  };
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (!*run) continue;
    const std::string name = "Controller, " + (*run)->data.scan.info.loop + ": ";
    add(name + "wake-up", (*run)->data.wake_up);
    add(name + "compute", (*run)->data.compute);
  }
  return histograms;
}

}  // namespace stillframe::judge

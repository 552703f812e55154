#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/page/envelope.hpp"
#include "report/page/mode_shapes.hpp"
#include "report/page/page_tables.hpp"

// Everything that stands on the page. A part that is empty or absent is not drawn and has no
// heading. Numbers that are not finite count as absent. SI units unless a comment says otherwise.
namespace stillframe::page {

/// Measured singular values (or |T|) at some frequencies, with the 95 % band of each. A value whose
/// band has no upper end could be anything: it is counted, and not drawn.
struct MeasuredValues {
  std::vector<double> frequencies_hz;    ///< n_f, Hz
  Eigen::MatrixXd values, lower, upper;  ///< n_f x n_s; bands may be 0 x 0
  std::vector<double> coherence;         ///< n_f, 0 to 1, or empty
  Eigen::MatrixXd difference_db;         ///< n_f x n_s, measured less predicted, or 0 x 0

  bool has_bands() const {
    return upper.size() > 0 && lower.rows() == values.rows() && lower.cols() == values.cols() &&
           upper.rows() == values.rows() && upper.cols() == values.cols();
  }
  bool is_bounded(Eigen::Index f, Eigen::Index s) const {
    return !has_bands() || std::isfinite(upper(f, s));
  }
};

/// The deck's figure: singular values over frequency, predicted and measured.
struct SingularValueFigure {
  std::string quantity = "floor to frame acceleration";
  bool of_floor = true;                ///< whether that is so
  std::vector<double> frequencies_hz;  ///< n_g, Hz, of the predicted curves
  Eigen::MatrixXd open, closed;        ///< n_g x n_s, as the sampled loop must show them
  Eigen::MatrixXd closed_continuous;   ///< n_g x n_s, of the continuous design
  std::vector<double> target;          ///< n_g, the curve that the gains aim at
  MeasuredValues open_measured, closed_measured;
  double allowed_db = 0;  ///< drawn as a band about no error, if positive
};

/// |T| of one direction, from floor to frame; or of one leg, from its actuator to its force sensor:
/// then passive is of the scene as it was, active of the updated one.
struct TransmissibilityAxis {
  std::string axis;
  std::vector<double> frequencies_hz;                ///< n_g, Hz
  std::vector<double> passive, active;               ///< n_g, predicted
  MeasuredValues passive_measured, active_measured;  ///< n_s = 1
};

/// Time histories of one direction or one leg, of one unit.
struct HistoryAxis {
  std::string axis;
  std::string unit = "m/s\u00b2";
  Envelope floor, passive, active;
};
/// The force that a leg applied.
struct LegHistory {
  std::string leg;
  Envelope force;                 ///< N
  std::optional<double> limit_n;  ///< N
};

/// A value over frequency.
struct Curve {
  std::string name;                    ///< of a reference; empty for floor, passive and active
  std::vector<double> frequencies_hz;  ///< n, Hz
  std::vector<double> values;          ///< n
  bool empty() const { return frequencies_hz.empty(); }
};
struct SignalCurves {
  Curve floor, passive, active;
};
/// Spectra of one direction. Any of the three may be empty. PSDs may be as fine as they come: the
/// page keeps the smallest and the largest value of each of at most 500 equal steps of log f.
struct SpectraAxis {
  std::string axis;
  SignalCurves third_octaves;   ///< m/s rms, a band each, at its nominal frequency
  SignalCurves density;         ///< m^2/s^4/Hz of acceleration
  SignalCurves cumulative_rms;  ///< m/s^2, from 0 to each frequency
};
struct SpectraFigures {
  std::vector<SpectraAxis> axes;
  std::vector<Curve> criteria;  ///< m/s rms: VC-A to VC-G
  std::vector<Curve> models;    ///< m^2/s^4/Hz: Peterson's NLNM and NHNM
};

/// How often a duration fell into each bin.
struct Histogram {
  std::string name;                  ///< as in "controller, active: wake-up"
  std::vector<double> edges_us;      ///< n + 1, microseconds, rising
  std::vector<std::int64_t> counts;  ///< n
};

struct PageData {
  Head head;
  std::vector<Warning> warnings;   ///< drawn first, severe ones before the others
  std::vector<AxisResult> result;  ///< the customer's table
  std::vector<Table> checks;       ///< what was asked, below it
  std::optional<SingularValueFigure> singular_values;
  std::vector<TransmissibilityAxis> transmissibility;
  std::vector<TransmissibilityAxis> fit;  ///< of the legs of a rig
  std::optional<ModeShapes> modes;
  std::vector<HistoryAxis> histories;
  std::vector<LegHistory> leg_forces;
  SpectraFigures spectra;
  std::vector<Table> shock;   ///< settling after a shock
  std::vector<Table> noise;   ///< noise floor apart from floor input
  std::vector<Table> effort;  ///< of the actuators
  std::vector<Histogram> histograms;
  std::vector<Table> timing;
  std::vector<MatrixTable> gains;
  std::vector<Text> texts;  ///< scene, floor: as they were written
  std::vector<Table> log;   ///< how whole the logs are: gaps, damage, foreign channels
};

}  // namespace stillframe::page

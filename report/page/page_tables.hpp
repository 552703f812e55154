#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "report/verdict/judgement.hpp"

// The parts of the page that are text and tables.
namespace stillframe::page {

/// What the page is about. Texts that are empty and numbers that are absent are left out.
struct Head {
  std::string title;
  std::string program_version;
  std::string scene_name, scene_hash;
  std::string mode;                      ///< lock step, wall clock, single process
  std::string date;                      ///< of the run, as it is to be read
  std::vector<std::string> loops;        ///< passive, active
  std::optional<double> sample_rate_hz;  ///< Hz
  std::optional<double> duration_s;      ///< s
  std::optional<double> delay_samples;
  std::optional<report::Outcome> outcome;  ///< the badge; absent: there is none
  std::vector<std::string> reasons;        ///< of the outcome, a sentence each
  std::vector<std::string> headlines;      ///< the result in a sentence or two
};

enum class Severity { severe, warning, note };
struct Warning {
  Severity severity = Severity::warning;
  std::string text;
};

/// One signal's numbers in one direction.
struct Level {
  double rms_acceleration = 0;   ///< m/s^2
  double peak_acceleration = 0;  ///< m/s^2
  double band_velocity = 0;      ///< m/s rms, largest one-third-octave band
  double band_hz = 0;            ///< Hz, nominal centre of that band
  std::string vibration_class;   ///< VC-A ... VC-G, or above VC-A
};
struct AxisResult {
  std::string axis;
  std::optional<Level> floor, passive, active;
};

/// A table as it is to be read: numbers come as text with sensible digits, units in the headers.
/// A cell that looks like a number is set to the right. Errors (write_page): InputError for a row
/// of another length than columns.
struct Table {
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// A matrix shaded by the size of its entries.
struct MatrixTable {
  std::string name;                        ///< as in "K_P"
  std::string unit;                        ///< empty: none
  std::vector<std::string> rows, columns;  ///< their names
  Eigen::MatrixXd values;
};

/// A text as it was written, in a part that opens and closes.
struct Text {
  std::string name, text;
};

}  // namespace stillframe::page

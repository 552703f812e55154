#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

// Pictures as PNG, 1600 x 1000, drawn by the program gnuplot. Set-up.
// Every function throws InputError if gnuplot is missing or fails, or the folder cannot be written
// to, and std::invalid_argument on shapes that do not match. Parts that are left empty are not
// drawn.

/// Measured singular values of one loop, on the picture as points.
struct MeasuredValues {
  std::vector<double> frequencies_hz;  ///< n_f, Hz
  Eigen::MatrixXd singular_values;     ///< n_f x n_s
};

/// Singular values over frequency.
struct SingularValuePlot {
  std::string title;
  std::string quantity = "floor to frame acceleration";  ///< on the axis
  std::vector<double> frequencies_hz;                    ///< n_g, Hz, of the predicted curves
  Eigen::MatrixXd open_predicted;                        ///< n_g x n_s
  Eigen::MatrixXd closed_predicted;                      ///< n_g x n_s, of the loop that runs
  Eigen::MatrixXd closed_continuous;                     ///< n_g x n_s, of its law without sampling
  MeasuredValues open_measured, closed_measured;
  double target_frequency_hz = 0;  ///< omega_d / 2 pi; no target curve if zero
  double target_damping = 0;       ///< zeta
  double lowest_db = -80;          ///< lower end of the axis
};
void plot_singular_values(const SingularValuePlot& plot, const std::filesystem::path& path);

/// Measured less predicted singular values in dB (PredictionError::difference_db), over frequency.
struct DifferencePlot {
  std::string title;
  std::vector<double> frequencies_hz;  ///< n_f, Hz
  Eigen::MatrixXd open_db, closed_db;  ///< n_f x n_s, dB, NaN is not drawn
  double allowed_db = 0.2;             ///< drawn as a band
};
void plot_differences(const DifferencePlot& plot, const std::filesystem::path& path);

/// One-third-octave rms velocity of one direction, m/s, each of third_octave_bands().
struct AxisBands {
  std::string axis;  ///< as in "x"
  Eigen::VectorXd floor, passive, active;
};
struct OctavePlot {
  std::string title;
  std::vector<AxisBands> axes;  ///< a panel each, one to six
};
void plot_third_octaves(const OctavePlot& plot, const std::filesystem::path& path);

/// Accelerations of one direction over time, a row a part of it: n x 3, time in s, smallest and
/// largest value in m/s^2.
struct AxisHistory {
  std::string axis;  ///< as in "x"
  Eigen::MatrixXd floor, passive, active;
};
struct HistoryPlot {
  std::string title;
  std::vector<AxisHistory> axes;  ///< a panel each, one to six
};
void plot_histories(const HistoryPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

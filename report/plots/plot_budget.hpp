#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// One axis held in one way: rms velocities, m/s, in third_octave_bands(); NaN and 0 are not drawn.
struct BudgetPanel {
  std::string axis, method;
  Eigen::VectorXd total, measured;       ///< measured: empty, there is no run
  std::vector<Eigen::VectorXd> sources;  ///< each by itself
};

struct BudgetPlot {
  std::string title;
  std::vector<std::string> sources;
  std::vector<BudgetPanel> panels;  ///< row by row, an axis a row
  std::size_t n_columns = 1;
};

/// Draws a PNG; up to six axes. Set-up. Errors: as run_gnuplot; InputError for more axes;
/// std::invalid_argument on shapes.
void plot_budget(const BudgetPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

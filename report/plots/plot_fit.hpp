#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// A size over frequency: measured, as a model has it, and as another one has it.
struct FitPanel {
  std::string title;
  Eigen::VectorXd measured, fitted, other;  ///< n_f
  Eigen::VectorXd doubt = {};               ///< n_f, of measured, each way; empty: not drawn
};

struct FitPlot {
  std::string title, left_label;
  std::string fitted, other;       ///< what the models are called
  Eigen::VectorXd frequencies_hz;  ///< n_f
  std::vector<FitPanel> panels;    ///< the first six are drawn
};

/// In decibels. Set-up. Errors: as the pictures of report/plots/plots.hpp.
void plot_fit(const FitPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

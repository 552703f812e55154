#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// What a leg's force sensor reads over its force, size, over frequency.
struct FitPanel {
  std::string title;
  Eigen::VectorXd measured, fitted, before;  ///< n_f, 1
};

struct FitPlot {
  std::string title;
  Eigen::VectorXd frequencies_hz;  ///< n_f
  std::vector<FitPanel> legs;      ///< the first six are drawn
};

/// A panel a leg. Set-up. Errors: as the pictures of report/plots/plots.hpp.
void plot_fit(const FitPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

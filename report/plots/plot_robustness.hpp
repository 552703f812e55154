#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// A bar of a histogram: the lower end of the bin, and the share of all that fall into it.
struct HistogramBar {
  double from = 0, share = 0;
};

/// The largest singular value from floor to frame over frequency, for many plants, and the least
/// damping ratio of each. Curves that are left empty are not drawn.
struct RobustnessPlot {
  std::string title;
  std::vector<double> frequencies_hz;  ///< n_f, Hz
  Eigen::VectorXd nominal;             ///< n_f
  Eigen::VectorXd low, high;           ///< n_f, edges of the band that holds 90 % of the plants
  Eigen::VectorXd most;                ///< n_f, largest of all samples at each frequency
  Eigen::VectorXd worst;               ///< n_f, of the plant with the highest peak
  std::vector<HistogramBar> damping;   ///< ascending
  double damping_width = 0;            ///< of a bar
  double nominal_damping = 0;
};

/// Two panels, one above the other. Set-up. Errors: as the pictures of report/plots/plots.hpp.
void plot_robustness(const RobustnessPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

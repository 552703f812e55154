#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// Isolation against margin of one way to design a feedback; points in any order.
struct MarginCurve {
  std::string label;
  Eigen::VectorXd disk, level_db;
};

struct MarginPlot {
  std::string title, quantity;
  double wished_disk = 0;  ///< drawn as a line
  std::vector<MarginCurve> curves;
};

/// Draws a PNG. Set-up. Errors: as run_gnuplot; std::invalid_argument on sizes.
void plot_margins(const MarginPlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

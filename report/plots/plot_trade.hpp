#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// Margin and price of sampling of one target over sample rates; NaN is not drawn.
struct TradePlotCurve {
  std::string label;               ///< as in "5 Hz"
  Eigen::VectorXd disk, price_db;  ///< n_r
};

/// A column of two panels for each delay.
struct TradePlotColumn {
  std::string title;  ///< as in "delay 1 sample"
  std::vector<TradePlotCurve> curves;
};

struct TradePlot {
  std::string title;
  Eigen::VectorXd rates_hz;  ///< n_r
  std::vector<TradePlotColumn> columns;
};

/// Draws a PNG. Set-up. Errors: as run_gnuplot; std::invalid_argument on shapes.
void plot_trade(const TradePlot& plot, const std::filesystem::path& path);

}  // namespace stillframe::report

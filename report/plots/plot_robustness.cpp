#include "report/plots/plot_robustness.hpp"

#include <algorithm>
#include <cmath>

#include "core/numerics/decibels.hpp"
#include "core/systems/frequency_range.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr const char* band_style =
    " with filledcurves fillstyle solid noborder linecolor rgb '#B9D7EA'";
constexpr const char* most_style = " with lines linewidth 2 dashtype (4,6) linecolor rgb '#0072B2'";
constexpr const char* worst_style = " with lines linewidth 3 linecolor rgb '#D55E00'";
constexpr const char* nominal_style = " with lines linewidth 3 linecolor rgb 'black'";

/// Frequency and curves in dB as columns.
MatrixXd columns_of(const RobustnessPlot& plot, const std::vector<const VectorXd*>& curves) {
  const auto n = static_cast<Index>(plot.frequencies_hz.size());
  MatrixXd table(n, static_cast<Index>(curves.size()) + 1);
  table.col(0) = Eigen::Map<const VectorXd>(plot.frequencies_hz.data(), n);
  for (size_t c = 0; c < curves.size(); ++c) {
    require(curves[c]->size() == n, "a curve of " + std::to_string(curves[c]->size()) +
                                        " values for " + std::to_string(n) + " frequencies");
    table.col(static_cast<Index>(c) + 1) = decibels(*curves[c]);
  }
  return table;
}

std::string envelope_panel(const RobustnessPlot& plot) {
  std::string script =
      margins(0.09, 0.965, 0.49, 0.92) +
      frequency_axis(plot.frequencies_hz.front(), plot.frequencies_hz.back(), "frequency (Hz)") +
      "set ylabel 'largest singular value (dB)'\nset ytics 20\nset mytics 2\n" +
      "set yrange [-80<*:*]\n";
  std::vector<std::string> parts;
  const auto add = [&](const char* name, const std::vector<const VectorXd*>& curves,
                       const char* columns, const char* style) {
    if (curves.front()->size() == 0) return;
    script += plot_data(name, columns_of(plot, curves));
    parts.push_back(std::string("$") + name + " using " + columns + style);
  };
  add("band", {&plot.low, &plot.high}, "1:2:3", band_style);
  add("most", {&plot.most}, "1:2", most_style);
  add("worst", {&plot.worst}, "1:2", worst_style);
  add("nominal", {&plot.nominal}, "1:2", nominal_style);
  return script + "plot " + joined(parts) + "\n";
}

std::string damping_panel(const RobustnessPlot& plot) {
  const auto n = static_cast<Index>(plot.damping.size());
  MatrixXd bars(n, 2);
  for (Index i = 0; i < n; ++i) {
    const HistogramBar& bar = plot.damping[static_cast<size_t>(i)];
    bars.row(i) << bar.from + plot.damping_width / 2, 100 * bar.share;
  }
  const double least = std::min(bars(0, 0), plot.nominal_damping) - 2 * plot.damping_width;
  const double most = std::max(bars(n - 1, 0), plot.nominal_damping) + 2 * plot.damping_width;
  const std::string nominal = plot_number(plot.nominal_damping);
  return margins(0.09, 0.965, 0.17, 0.385) + "unset logscale\nset xtics autofreq\nset ytics 0," +
         plot_number(rounded_up(bars.col(1).maxCoeff() / 3)) +
         "\nset mytics 1\nset yrange [0:*]\n"
         "set xrange [" +
         plot_number(least) + ":" + plot_number(most) + "]\n" +
         "set xlabel 'damping ratio of the least damped pole (unstable below 0)'\n"
         "set ylabel 'plants (%)'\n" +
         "set boxwidth " + plot_number(plot.damping_width) + "\n" + plot_data("bars", bars) +
         "set arrow from " + nominal + ", graph 0 to " + nominal +
         ", graph 1 nohead front linewidth 3 linecolor rgb 'black'\n" +
         "plot $bars using 1:($1 < 0 ? NaN : $2) with boxes fillstyle solid noborder linecolor rgb "
         "'#6BAED6', $bars using 1:($1 < 0 ? $2 : NaN) with boxes fillstyle solid noborder "
         "linecolor rgb '#D55E00'\n";
}

}  // namespace

void plot_robustness(const RobustnessPlot& plot, const std::filesystem::path& path) {
  require(plot.frequencies_hz.size() > 1, "fewer than two frequencies");
  Surroundings around{.title = plot.title, .left_label = "", .legend = {}};
  around.legend.push_back(legend_entry(nominal_style, "as modelled"));
  if (plot.low.size() > 0) {
    around.legend.push_back(legend_entry(band_style, "90 % of the plants"));
    around.legend.push_back(legend_entry(most_style, "largest sampled"));
  }
  if (plot.worst.size() > 0)
    around.legend.push_back(legend_entry(worst_style, "highest peak found"));
  std::string script = surround(around) + envelope_panel(plot);
  if (!plot.damping.empty()) script += damping_panel(plot);
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

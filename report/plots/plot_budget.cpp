#include "report/plots/plot_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/errors/input_error.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_rows = 6;
constexpr double decades_shown = 5;  ///< of sources below the highest point

const char* colour_of(std::size_t source) {
  constexpr const char* colours[] = {"'#0072B2'", "'#D55E00'", "'#009E73'", "'#CC79A7'",
                                     "'#E69F00'", "'#56B4E9'", "'#8C6D31'", "'#7570B3'"};
  return colours[source % std::size(colours)];
}

std::string source_style(std::size_t source) {
  // A second round of the colours is dashed.
  return std::string(" with lines linewidth 2.5 linecolor rgb ") + colour_of(source) +
         (source >= 8 ? " dashtype 2" : "");
}

constexpr const char* total_style = " with lines linewidth 5 linecolor rgb '#202020'";
constexpr const char* measured_style =
    " with points pointtype 6 pointsize 1.3 linewidth 2 linecolor rgb '#202020'";
constexpr const char* limits_style = " with lines linewidth 1.2 linecolor rgb '#A0A0A0'";

MatrixXd table_in_um(const VectorXd& velocity) {
  const std::vector<OctaveBand> bands = third_octave_bands();
  require(velocity.size() == std::ssize(bands), "a budget has the bands from 1 to 80 Hz");
  MatrixXd table(velocity.size(), 2);
  for (Index i = 0; i < velocity.size(); ++i) {
    const double value = velocity(i) > 0 ? 1e6 * velocity(i) : std::nan("");
    table.row(i) << bands[static_cast<std::size_t>(i)].centre_hz, value;
  }
  return table;
}

std::string limits_block() {
  std::string block = "$limits << end_of_data\n";
  for (const VibrationCriterion& criterion : vibration_criteria()) {
    for (const OctaveBand& band : third_octave_bands()) {
      if (!criterion.applies(band.centre_hz)) continue;
      block += plot_number(band.centre_hz) + " " +
               plot_number(1e6 * criterion.limit(band.centre_hz)) + "\n";
    }
    block += "\n";
  }
  return block + "end_of_data\n";
}

std::string budget_panel(const BudgetPlot& plot, std::size_t p) {
  const BudgetPanel& panel = plot.panels[p];
  const std::size_t n_rows = plot.panels.size() / plot.n_columns, row = p / plot.n_columns,
                    column = p % plot.n_columns;
  const double width = 0.89 / static_cast<double>(plot.n_columns),
               height = 0.82 / static_cast<double>(n_rows);
  const double left = 0.1 + width * static_cast<double>(column),
               top = 0.93 - height * static_cast<double>(row);
  std::string script = margins(left, left + width - 0.02, top - height + 0.035, top - 0.025);
  script += "set title " + plot_text(panel.axis + ", " + panel.method) +
            " noenhanced font ',18' offset 0,-0.7\n";
  script += column == 0 ? "set format y '10^{%L}'\n" : "set format y ''\n";
  script += row + 1 == n_rows ? "set format x '%g'\n" : "set format x ''\n";
  std::vector<std::string> parts{std::string("$limits using 1:2") + limits_style};
  const auto add = [&](const VectorXd& velocity, const std::string& name,
                       const std::string& style) {
    if (velocity.size() == 0 || !(velocity.array() > 0).any()) return;
    const std::string block = name + "_" + std::to_string(p);
    script += plot_data(block, table_in_um(velocity));
    parts.push_back("$" + block + " using 1:2" + style);
  };
  add(panel.total, "total", total_style);
  for (std::size_t s = 0; s < panel.sources.size(); ++s) {
    add(panel.sources[s], "source" + std::to_string(s), source_style(s));
  }
  add(panel.measured, "measured", measured_style);
  return script + "plot " + joined(parts) + "\n";
}

}  // namespace

void plot_budget(const BudgetPlot& plot, const std::filesystem::path& path) {
  require(plot.n_columns > 0 && !plot.panels.empty() && plot.panels.size() % plot.n_columns == 0,
          "a budget has as many panels in every row");
  if (plot.panels.size() / plot.n_columns > most_rows) {
    throw InputError("--plot: found " + std::to_string(plot.panels.size() / plot.n_columns) +
                     " axes, allowed are up to " + std::to_string(most_rows) +
                     "; choose some by --signal");
  }
  Surroundings around{.title = plot.title + ": error budget",
                      .left_label = "rms velocity in one-third octaves from 1 to 80 Hz (µm/s)",
                      .legend = {}};
  double highest = 0;
  bool measured = false;
  for (const BudgetPanel& panel : plot.panels) {
    for (const double value : panel.total)
      highest = std::max(highest, std::isnan(value) ? 0 : value);
    measured = measured || panel.measured.size() > 0;
  }
  around.legend.push_back(std::string("keyentry") + total_style + " title 'all'");
  if (measured) {
    around.legend.push_back(std::string("keyentry") + measured_style + " title 'measured'");
  }
  for (std::size_t s = 0; s < plot.sources.size(); ++s) {
    around.legend.push_back("keyentry" + source_style(s) + " title " + plot_text(plot.sources[s]));
  }
  const double top = highest > 0 ? std::ceil(std::log10(2e6 * highest)) : 0;
  std::string script = surround(around) + frequency_axis(0.89, 90, "") +
                       "set logscale y 10\nset mytics 10\nset yrange [1e" +
                       std::to_string(static_cast<int>(top - decades_shown)) + ":1e" +
                       std::to_string(static_cast<int>(top)) + "]\n" + limits_block();
  for (std::size_t p = 0; p < plot.panels.size(); ++p) script += budget_panel(plot, p);
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

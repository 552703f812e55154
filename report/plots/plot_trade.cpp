#include "report/plots/plot_trade.hpp"

#include <algorithm>

#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr const char* colours[] = {"'#56B4E9'", "'#0072B2'", "'#E69F00'", "'#D55E00'"};

std::string line_style(size_t i) {
  return std::string(" with lines linewidth 3 linecolor rgb ") + colours[i % std::size(colours)];
}

/// Rates and the curves of one panel as columns.
MatrixXd table_of(const TradePlot& plot, const TradePlotColumn& column, bool disk) {
  MatrixXd table(plot.rates_hz.size(), static_cast<Index>(column.curves.size()) + 1);
  table.col(0) = plot.rates_hz;
  for (size_t i = 0; i < column.curves.size(); ++i) {
    const Eigen::VectorXd& values = disk ? column.curves[i].disk : column.curves[i].price_db;
    require(values.size() == plot.rates_hz.size(), "a curve that does not fit the rates");
    table.col(static_cast<Index>(i) + 1) = values;
  }
  return table;
}

/// What a recommended rate has to keep, beside the last panel in words.
std::string bound(bool disk, bool last) {
  const std::string at = disk ? "0.5" : "3";
  const std::string text = disk ? "\"at least\\n0.5\"" : "\"at most\\n3 dB\"";
  return "set arrow 1 from graph 0, first " + at + " to graph 1, first " + at +
         " nohead dashtype 3\n" +
         (last ? "set label 2 " + text + " at graph 1.02, first " + at + " left font ',14'\n"
               : "unset label 2\n");
}

/// Whether a curve has a value anywhere, which an unstable loop has not.
bool is_drawn(const TradePlot& plot, size_t curve) {
  return std::any_of(plot.columns.begin(), plot.columns.end(), [&](const TradePlotColumn& column) {
    return !column.curves.at(curve).price_db.array().isNaN().all();
  });
}

std::string panel(const TradePlot& plot, size_t c, bool disk) {
  const double n = static_cast<double>(plot.columns.size()), width = 0.885 / n;
  const double left = 0.09 + static_cast<double>(c) * width;
  const TradePlotColumn& column = plot.columns[c];
  std::string script = margins(left, left + width - 0.05, disk ? 0.54 : 0.17, disk ? 0.88 : 0.49);
  script += frequency_axis(plot.rates_hz(0), plot.rates_hz(plot.rates_hz.size() - 1),
                           disk ? "" : "sample rate (Hz)");
  // The panels of a column share the labels of the lower one.
  script += disk ? "set format x ''\n" : "set format x '%.0s%c'\n";
  // Room above the panels for their titles, which a multiplot takes from the panel itself.
  script += disk ? "set label 1 " + plot_text(column.title) + " at graph 0.5, 1.05 center\n"
                 : std::string("unset label 1\n");
  script += disk ? "set yrange [0:1.6]\nset ytics 0.4\nset mytics 2\n"
                 : "set yrange [-3:30]\nset ytics 6\nset mytics 2\n";
  script += bound(disk, c + 1 == plot.columns.size());
  script += c == 0 ? std::string("set ylabel '") +
                         (disk ? "disk margin of all legs" : "price of sampling (dB)") + "'\n"
                   : std::string("unset ylabel\n");
  const std::string name = (disk ? "disk" : "price") + std::to_string(c);
  script += plot_data(name, table_of(plot, column, disk));
  std::vector<std::string> parts;
  for (size_t i = 0; i < column.curves.size(); ++i) {
    parts.push_back("$" + name + " using 1:" + std::to_string(i + 2) + line_style(i));
  }
  return script + "plot " + joined(parts) + "\n";
}

}  // namespace

void plot_trade(const TradePlot& plot, const std::filesystem::path& path) {
  require(!plot.columns.empty() && plot.rates_hz.size() > 1, "nothing to trade");
  Surroundings around{.title = plot.title, .left_label = "", .legend = {}};
  for (size_t i = 0; i < plot.columns.front().curves.size(); ++i) {
    if (!is_drawn(plot, i)) continue;
    around.legend.push_back("keyentry" + line_style(i) + " title " +
                            plot_text("target " + plot.columns.front().curves[i].label));
  }
  if (around.legend.empty()) around.legend.push_back("keyentry with dots title 'all unstable'");
  std::string script = surround(around);
  for (const bool disk : {true, false}) {
    for (size_t c = 0; c < plot.columns.size(); ++c) script += panel(plot, c, disk);
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

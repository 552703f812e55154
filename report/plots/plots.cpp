#include "report/plots/plots.hpp"

#include <algorithm>
#include <cmath>

#include "core/numerics/decibels.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// One panel over the whole picture, the legend below it in the given number of rows.
std::string one_panel(const std::string& title, int n_key_rows) {
  const double key_height = 0.035 * n_key_rows;
  std::string script = frame_style() + margins(0.1, 0.965, 0.125 + key_height, 0.92);
  script += "set key at screen 0.53," + plot_number(0.015 + 0.5 * key_height) + " maxrows " +
            std::to_string(n_key_rows) + "\n";
  if (!title.empty()) script += "set title " + plot_text(title) + " noenhanced font ',22'\n";
  return script;
}

MatrixXd with_abscissa(const std::vector<double>& x, const MatrixXd& columns, const char* what) {
  const auto n = static_cast<Index>(x.size());
  require(columns.rows() == n, std::string(what) + ": " + std::to_string(columns.rows()) +
                                   " rows for " + std::to_string(n) + " frequencies");
  MatrixXd table(n, columns.cols() + 1);
  table << Eigen::Map<const VectorXd>(x.data(), n), columns;
  return table;
}

/// Draws columns 2 ... of a datablock alike, one entry in the legend for all.
std::string curves(const std::string& block, Index n_columns, const std::string& style,
                   const std::string& title) {
  return "for [c=2:" + std::to_string(n_columns + 1) + "] $" + block + " using 1:(column(c)) " +
         style + " title (c==2 ? " + plot_text(title) + " : '')";
}

std::string points(const char* colour, int type) {
  return "with points pointtype " + std::to_string(type) +
         " pointsize 1.5 linewidth 2 linecolor rgb " + colour;
}

MatrixXd target_curve(const SingularValuePlot& plot) {
  MatrixXd curve(static_cast<Index>(plot.frequencies_hz.size()), 1);
  for (Index k = 0; k < curve.rows(); ++k) {
    // |omega_d^2 / (s^2 + 2 zeta omega_d s + omega_d^2)| at s = j r omega_d.
    const double r = plot.frequencies_hz[static_cast<std::size_t>(k)] / plot.target_frequency_hz;
    curve(k) = 1 / std::hypot(1 - r * r, 2 * plot.target_damping * r);
  }
  return decibels(curve);
}

/// The smallest and largest of the frequencies that a plot shows. Errors: std::invalid_argument for
/// none.
std::pair<double, double> frequency_range(std::initializer_list<const std::vector<double>*> lists) {
  double lowest = INFINITY, highest = 0;
  for (const auto* list : lists) {
    for (const double f : *list) {
      require(f > 0, "a frequency that is not positive");
      lowest = std::min(lowest, f);
      highest = std::max(highest, f);
    }
  }
  require(highest > lowest, "fewer than two frequencies");
  return {lowest, highest};
}

}  // namespace

void plot_singular_values(const SingularValuePlot& plot, const std::filesystem::path& path) {
  const auto [lowest, highest] =
      frequency_range({&plot.frequencies_hz, &plot.open_measured.frequencies_hz,
                       &plot.closed_measured.frequencies_hz});
  std::string script = one_panel(plot.title, 2) + frequency_axis(lowest, highest, "frequency (Hz)");
  script += "set ylabel " + plot_text("singular values, " + plot.quantity + " (dB)") + "\n";
  script += "set yrange [" + plot_number(plot.lowest_db) + ":*]\nset ytics 20\nset mytics 2\n";
  std::vector<std::string> parts;
  const auto add = [&](const std::string& name, const std::vector<double>& f,
                       const MatrixXd& values_db, const std::string& style,
                       const std::string& title) {
    if (values_db.size() == 0) return;
    script += plot_data(name, with_abscissa(f, values_db, title.c_str()));
    parts.push_back(curves(name, values_db.cols(), style, title));
  };
  const std::string line = "with lines linewidth 3 linecolor rgb ";
  add("open", plot.frequencies_hz, decibels(plot.open_predicted), line + passive_colour,
      "open loop, predicted");
  add("closed", plot.frequencies_hz, decibels(plot.closed_predicted),
      line + active_colour + " dashtype (12,6)", "closed loop, predicted");
  add("continuous", plot.frequencies_hz, decibels(plot.closed_continuous),
      "with lines linewidth 1.2 linecolor rgb " + std::string(active_colour),
      "closed loop, continuous law");
  add("open_measured", plot.open_measured.frequencies_hz,
      decibels(plot.open_measured.singular_values), points(passive_colour, 6),
      "open loop, measured");
  add("closed_measured", plot.closed_measured.frequencies_hz,
      decibels(plot.closed_measured.singular_values), points(active_colour, 8),
      "closed loop, measured");
  if (plot.target_frequency_hz > 0) {
    add("target", plot.frequencies_hz, target_curve(plot),
        "with lines linewidth 1.2 linecolor rgb 'black'", "target of the design");
  }
  run_gnuplot(script + "plot " + joined(parts) + "\n", path);
}

void plot_differences(const DifferencePlot& plot, const std::filesystem::path& path) {
  const auto [lowest, highest] = frequency_range({&plot.frequencies_hz});
  std::string script =
      one_panel(plot.title, 1) + frequency_axis(0.92 * lowest, 1.08 * highest, "frequency (Hz)");
  script += "set ylabel 'measured less predicted singular value (dB)'\n";
  const std::string allowed = plot_number(plot.allowed_db);
  script += "set yrange [*<-" + plot_number(1.25 * plot.allowed_db) + ":" +
            plot_number(1.25 * plot.allowed_db) + "<*]\n";
  std::vector<std::string> parts = {
      allowed + " with lines linewidth 2 dashtype (12,6) linecolor rgb 'black' title 'allowed'",
      "-" + allowed + " with lines linewidth 2 dashtype (12,6) linecolor rgb 'black' notitle"};
  const auto add = [&](const std::string& name, const MatrixXd& db, const char* colour, int type,
                       const std::string& title) {
    if (db.size() == 0) return;
    script += plot_data(name, with_abscissa(plot.frequencies_hz, db, title.c_str()));
    parts.push_back(curves(name, db.cols(), points(colour, type), title));
  };
  add("open", plot.open_db, passive_colour, 6, "open loop");
  add("closed", plot.closed_db, active_colour, 8, "closed loop");
  run_gnuplot(script + "plot " + joined(parts) + "\n", path);
}

}  // namespace stillframe::report

#include <algorithm>
#include <cmath>
#include <numeric>

#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"
#include "report/plots/plots.hpp"

namespace stillframe::report {

using Eigen::MatrixXd;

namespace {

constexpr double mm_per_m = 1e3;
/// Of the names of the axes, between the title of all of them and the labels of the tics.
constexpr double axis_name_place = 0.047;

/// The three signals of a panel, in the order of the legend.
struct Signal {
  const char* name;
  const char* block;
  MatrixXd AxisHistory::*values;
  const char* colour;
};
constexpr Signal signals[] = {{"floor", "floor", &AxisHistory::floor, floor_colour},
                              {"frame, passive", "passive", &AxisHistory::passive, passive_colour},
                              {"frame, active", "active", &AxisHistory::active, active_colour}};

/// Largest magnitude; parts in which samples are missing are NaN.
double largest_of(const MatrixXd& rows) {
  const auto values = rows.rightCols(2).array();
  return values.isFinite().select(values.abs(), 0.0).maxCoeff();
}

/// Of all signals of a panel, mm/s^2.
double largest_of(const AxisHistory& axis) {
  double largest = 0;
  for (const Signal& signal : signals) {
    const MatrixXd& rows = axis.*signal.values;
    if (rows.size() > 0) largest = std::max(largest, mm_per_m * largest_of(rows));
  }
  return largest;
}

/// Zero and one round number on either side: more have no room in a low panel.
std::string three_tics(double largest) {
  if (!(largest > 0)) return "set ytics auto\nset yrange [*:*]\n";
  const double decade = std::pow(10, std::floor(std::log10(largest)));
  double tic = decade;
  for (const double step : {2.0, 5.0}) {
    if (step * decade <= largest) tic = step * decade;
  }
  return "set ytics (" + plot_number(-tic) + ", 0, " + plot_number(tic) + ")\nset yrange [" +
         plot_number(-largest) + ":" + plot_number(largest) + "]\n";
}

/// Mean size: a moment in which a loop takes over does not count as its peak does.
double mean_of(const MatrixXd& rows) {
  const auto values = rows.rightCols(2).array();
  return values.isFinite().select(values.abs(), 0.0).mean();
}

/// The signals that there are, the largest over the whole time first, so that none is hidden behind
/// another.
std::vector<const Signal*> drawing_order(const AxisHistory& axis) {
  std::vector<const Signal*> order;
  for (const Signal& signal : signals) {
    if ((axis.*signal.values).size() > 0) order.push_back(&signal);
  }
  std::stable_sort(order.begin(), order.end(), [&axis](const Signal* a, const Signal* b) {
    return mean_of(axis.*a->values) > mean_of(axis.*b->values);
  });
  return order;
}

std::string history_panel(const AxisHistory& axis, const std::string& suffix) {
  std::string script;
  std::vector<std::string> parts;
  for (const Signal* signal : drawing_order(axis)) {
    MatrixXd rows = axis.*signal->values;
    rows.rightCols(2) *= mm_per_m;
    const std::string block = signal->block + suffix;
    const std::string colour = std::string(" linecolor rgb ") + signal->colour;
    script += plot_data(block, rows);
    // The outline keeps a signal visible where its envelope is thinner than a pixel.
    parts.push_back("$" + block + " using 1:2:3 with filledcurves fillstyle solid noborder" +
                    colour);
    parts.push_back("$" + block + " using 1:2 with lines linewidth 1" + colour);
    parts.push_back("$" + block + " using 1:3 with lines linewidth 1" + colour);
  }
  require(!parts.empty(), "no signal along " + axis.axis);
  return script + "plot " + joined(parts) + "\n";
}

std::vector<std::string> legend_of(const std::vector<AxisHistory>& axes) {
  std::vector<std::string> legend;
  for (const Signal& signal : signals) {
    const bool drawn = std::any_of(axes.begin(), axes.end(), [&](const AxisHistory& axis) {
      return (axis.*signal.values).size() > 0;
    });
    if (!drawn) continue;
    legend.push_back(std::string("keyentry with lines linewidth 8 linecolor rgb ") + signal.colour +
                     " title " + plot_text(signal.name));
  }
  return legend;
}

double end_of(const std::vector<AxisHistory>& axes) {
  double end = 0;
  for (const AxisHistory& axis : axes) {
    for (const Signal& signal : signals) {
      const MatrixXd& rows = axis.*signal.values;
      if (rows.rows() > 0) end = std::max(end, rows(rows.rows() - 1, 0));
    }
  }
  return end;
}

}  // namespace

void plot_histories(const HistoryPlot& plot, const std::filesystem::path& path) {
  require(!plot.axes.empty() && plot.axes.size() <= most_panels, "one to six axes are drawn");
  const double end = end_of(plot.axes);
  require(end > 0, "no signal along any axis");
  std::string script = surround(
      {.title = plot.title, .left_label = "acceleration (mm/s²)", .legend = legend_of(plot.axes)});
  script += "set xrange [0:" + plot_number(end) + "]\n";
  const bool crowded = plot.axes.size() > 3;
  const double height = 0.81 / static_cast<double>(plot.axes.size());
  for (std::size_t p = 0; p < plot.axes.size(); ++p) {
    const double top = 0.93 - height * static_cast<double>(p);
    const bool lowest = p + 1 == plot.axes.size();
    script += margins(0.12, 0.975, top - height + 0.03, top);
    script += "set label 3 " + plot_text(plot.axes[p].axis) + " at screen " +
              plot_number(axis_name_place) + "," + plot_number(top - 0.5 * (height - 0.03)) +
              " center rotate noenhanced\n";
    if (crowded) script += three_tics(largest_of(plot.axes[p]));
    script += lowest ? "set format x '%g'\nset xlabel 'time (s)'\n" : "set format x ''\n";
    script += history_panel(plot.axes[p], std::to_string(p));
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

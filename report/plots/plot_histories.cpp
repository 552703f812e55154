#include <algorithm>
#include <numeric>

#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"
#include "report/plots/plots.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd envelope(const VectorXd& x, Index n_buckets) {
  require(n_buckets > 0, "an envelope of no buckets");
  const Index n = std::min(n_buckets, x.size());
  MatrixXd result(n, 3);
  for (Index b = 0; b < n; ++b) {
    const Index first = b * x.size() / n, end = (b + 1) * x.size() / n;
    const auto part = x.segment(first, end - first);
    result.row(b) << 0.5 * static_cast<double>(first + end - 1), part.minCoeff(), part.maxCoeff();
  }
  return result;
}

namespace {

constexpr std::size_t most_panels = 6;
constexpr double mm_per_m = 1e3;

// About one bucket a picture column: every peak stays visible, and no more points than the eye
// resolves.
constexpr Index n_history_buckets = 1400;

/// The three signals of a panel, in the order of the legend.
struct Signal {
  const char* name;
  const char* block;
  VectorXd AxisHistory::*values;
  const char* colour;
};
constexpr Signal signals[] = {{"floor", "floor", &AxisHistory::floor, floor_colour},
                              {"frame, passive", "passive", &AxisHistory::passive, passive_colour},
                              {"frame, active", "active", &AxisHistory::active, active_colour}};

/// The signals that there are, the one with the largest peak first, so that none is hidden behind
/// another.
std::vector<const Signal*> drawing_order(const AxisHistory& axis) {
  std::vector<const Signal*> order;
  for (const Signal& signal : signals) {
    if ((axis.*signal.values).size() > 0) order.push_back(&signal);
  }
  std::stable_sort(order.begin(), order.end(), [&axis](const Signal* a, const Signal* b) {
    return (axis.*a->values).lpNorm<Eigen::Infinity>() >
           (axis.*b->values).lpNorm<Eigen::Infinity>();
  });
  return order;
}

std::string history_panel(const AxisHistory& axis, const std::string& suffix,
                          double sample_rate_hz) {
  std::string script;
  std::vector<std::string> parts;
  for (const Signal* signal : drawing_order(axis)) {
    MatrixXd rows = envelope(axis.*signal->values, n_history_buckets);
    rows.col(0) /= sample_rate_hz;
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

Index longest_of(const std::vector<AxisHistory>& axes) {
  Index longest = 0;
  for (const AxisHistory& axis : axes) {
    longest = std::max({longest, axis.floor.size(), axis.passive.size(), axis.active.size()});
  }
  return longest;
}

}  // namespace

void plot_histories(const HistoryPlot& plot, const std::filesystem::path& path) {
  require(!plot.axes.empty() && plot.axes.size() <= most_panels, "one to six axes are drawn");
  require(plot.sample_rate_hz > 0, "a sample rate that is not positive");
  const Index longest = longest_of(plot.axes);
  require(longest > 0, "no signal along any axis");
  std::string script = surround(
      {.title = plot.title, .left_label = "acceleration (mm/s²)", .legend = legend_of(plot.axes)});
  script +=
      "set xrange [0:" + plot_number(static_cast<double>(longest) / plot.sample_rate_hz) + "]\n";
  const double height = 0.81 / static_cast<double>(plot.axes.size());
  for (std::size_t p = 0; p < plot.axes.size(); ++p) {
    const double top = 0.93 - height * static_cast<double>(p);
    const bool lowest = p + 1 == plot.axes.size();
    script += margins(0.105, 0.975, top - height + 0.03, top);
    script += "set ylabel " + plot_text(plot.axes[p].axis) + " noenhanced offset 1,0\n";
    script += lowest ? "set format x '%g'\nset xlabel 'time (s)'\n" : "set format x ''\n";
    script += history_panel(plot.axes[p], std::to_string(p), plot.sample_rate_hz);
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

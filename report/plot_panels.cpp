#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "report/gnuplot.hpp"
#include "report/plot_style.hpp"
#include "report/plots.hpp"
#include "report/spectra.hpp"
#include "report/vibration_criteria.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_panels = 6;

/// A common title above all panels, and a common legend below them.
std::string panel_frame(const std::string& title) {
  return frame_style() + "set multiplot\nset label 1 " + plot_text(title) +
         " at screen 0.5,0.965 center noenhanced font ',22'\n" +
         "set key at screen 0.53,0.03 maxrows 1\n";
}

/// After the first panel: what belongs to the whole picture is drawn once.
std::string once_only() { return "unset key\nunset label 1\n"; }

struct Range {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = 0;

  void include(const VectorXd& values, double scale) {
    for (const double value : values) {
      if (!(value > 0)) continue;
      lowest = std::min(lowest, scale * value);
      highest = std::max(highest, scale * value);
    }
  }
};

constexpr double um_per_m = 1e6, mm_per_m = 1e3;

/// Centre and value in um/s of each band.
MatrixXd band_table(const VectorXd& velocity) {
  const std::vector<OctaveBand> bands = third_octave_bands();
  require(velocity.size() == static_cast<Index>(bands.size()),
          std::to_string(velocity.size()) + " one-third-octave bands, expected " +
              std::to_string(bands.size()));
  MatrixXd table(velocity.size(), 2);
  for (Index i = 0; i < velocity.size(); ++i) {
    table.row(i) << bands[static_cast<std::size_t>(i)].centre_hz, um_per_m * velocity(i);
  }
  return table;
}

constexpr double lowest_octave_hz = 0.89, highest_octave_hz = 170;

/// Where the names of the criteria begin, right of the last band.
constexpr double criterion_name_hz = 86;

/// The limits of the criteria as one datablock of lines with gaps, and a name at the end of each.
std::string criteria_lines(const Range& range) {
  std::string block = "$criteria << end_of_data\n", labels;
  int tag = 10;
  for (const VibrationCriterion& criterion : vibration_criteria()) {
    for (const OctaveBand& band : third_octave_bands()) {
      block += plot_number(band.centre_hz) + " " +
               plot_number(um_per_m * criterion.limit(band.centre_hz)) + "\n";
    }
    block += "\n";
    const double end = um_per_m * criterion.velocity;
    if (end < range.lowest || end > range.highest) continue;
    labels += "set label " + std::to_string(tag++) + " " + plot_text(criterion.name) + " at " +
              plot_number(criterion_name_hz) + "," + plot_number(end) +
              " left font ',13' textcolor rgb '#606060'\n";
  }
  return block + "end_of_data\n" + labels;
}

/// Where panel p of n stands: at most three side by side.
struct PanelPlace {
  double left, right, bottom, top;
  bool leftmost, lowest;
};

PanelPlace side_by_side(std::size_t p, std::size_t n) {
  const std::size_t columns = std::min<std::size_t>(n, 3), rows = (n + 2) / 3;
  const std::size_t column = p % columns, row = p / columns;
  const double width = 0.905 / static_cast<double>(columns),
               height = 0.83 / static_cast<double>(rows);
  const double left = 0.085 + width * static_cast<double>(column);
  const double top = 0.92 - height * static_cast<double>(row);
  return {.left = left,
          .right = left + width - 0.02,
          .bottom = top - height + 0.055,
          .top = top - 0.03,
          .leftmost = column == 0,
          .lowest = p + columns >= n};
}

std::string octave_panel(const AxisBands& axis, const std::string& suffix,
                         const PanelPlace& place) {
  std::string script = margins(place.left, place.right, place.bottom, place.top);
  script += "set title " + plot_text(axis.axis) + " noenhanced font ',20' offset 0,-0.5\n";
  script += place.leftmost
                ? "set ylabel 'rms velocity in one-third octaves (µm/s)'\nset format y '%g'\n"
                : "unset ylabel\nset format y ''\n";
  script += place.lowest ? "set xlabel 'frequency (Hz)'\n" : "unset xlabel\n";
  std::vector<std::string> parts = {
      "$criteria using 1:2 with lines linewidth 1.2 linecolor rgb '#A0A0A0' title 'vibration "
      "criteria'"};
  const auto add = [&](const std::string& name, const VectorXd& velocity, const char* colour,
                       int type) {
    if (velocity.size() == 0) return;
    script += plot_data(name + suffix, band_table(velocity));
    parts.push_back("$" + name + suffix + " using 1:2 with linespoints linewidth 3 pointtype " +
                    std::to_string(type) + " pointsize 1.1 linecolor rgb " + colour + " title '" +
                    name + "'");
  };
  add("floor", axis.floor, floor_colour, 5);
  add("passive", axis.passive, passive_colour, 7);
  add("active", axis.active, active_colour, 9);
  return script + "plot " + joined(parts) + "\n";
}

}  // namespace

void plot_third_octaves(const OctavePlot& plot, const std::filesystem::path& path) {
  require(!plot.axes.empty() && plot.axes.size() <= most_panels, "one to six axes are drawn");
  Range range;
  for (const AxisBands& axis : plot.axes) {
    for (const VectorXd* velocity : {&axis.floor, &axis.passive, &axis.active}) {
      range.include(*velocity, um_per_m);
    }
  }
  // All criteria stay in the picture, whatever the data.
  range.lowest = std::min(range.lowest, 0.78) / 1.8;
  range.highest = std::max(range.highest, 60.0) * 1.8;
  std::string script =
      panel_frame(plot.title) + frequency_axis(lowest_octave_hz, highest_octave_hz, "");
  script += "set xtics (1, 2, 5, 10, 20, 50)\nset logscale y 10\nset mytics 10\nset yrange [" +
            plot_number(range.lowest) + ":" + plot_number(range.highest) + "]\n" +
            criteria_lines(range);
  for (std::size_t p = 0; p < plot.axes.size(); ++p) {
    script += octave_panel(plot.axes[p], std::to_string(p), side_by_side(p, plot.axes.size()));
    if (p == 0) script += once_only();
  }
  run_gnuplot(script, path);
}

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

// About one bucket a picture column: every peak stays visible, and no more points than the eye
// resolves.
constexpr Index n_history_buckets = 1400;

struct Trace {
  std::string name;
  const VectorXd* values;
  const char* colour;
  double peak;
};

/// The traces that there are, the largest first, so that none is hidden behind another.
std::vector<Trace> drawing_order(const AxisHistory& axis) {
  std::vector<Trace> traces;
  const auto add = [&](const char* name, const VectorXd& values, const char* colour) {
    if (values.size() > 0) {
      traces.push_back({name, &values, colour, values.lpNorm<Eigen::Infinity>()});
    }
  };
  add("floor", axis.floor, floor_colour);
  add("passive", axis.passive, passive_colour);
  add("active", axis.active, active_colour);
  std::stable_sort(traces.begin(), traces.end(),
                   [](const Trace& a, const Trace& b) { return a.peak > b.peak; });
  return traces;
}

std::string history_panel(const AxisHistory& axis, const std::string& suffix,
                          double sample_rate_hz) {
  std::string script;
  std::vector<std::string> parts;
  for (const Trace& trace : drawing_order(axis)) {
    MatrixXd rows = envelope(*trace.values, n_history_buckets);
    rows.col(0) /= sample_rate_hz;
    rows.rightCols(2) *= mm_per_m;
    const std::string block = trace.name + suffix,
                      style = std::string(" linecolor rgb ") + trace.colour;
    script += plot_data(block, rows);
    // The outline keeps a trace visible where its envelope is thinner than a pixel.
    parts.push_back("$" + block + " using 1:2:3 with filledcurves fillstyle solid noborder" +
                    style + " notitle");
    parts.push_back("$" + block + " using 1:2 with lines linewidth 1" + style + " notitle");
    parts.push_back("$" + block + " using 1:3 with lines linewidth 1" + style + " notitle");
  }
  require(!parts.empty(), "no signal along " + axis.axis);
  const std::array<std::pair<const char*, const char*>, 3> legend = {
      {{"floor", floor_colour},
       {"frame, passive", passive_colour},
       {"frame, active", active_colour}}};
  const std::array<const VectorXd*, 3> signals = {&axis.floor, &axis.passive, &axis.active};
  for (std::size_t i = 0; i < legend.size(); ++i) {
    if (signals[i]->size() == 0) continue;
    parts.push_back("keyentry with lines linewidth 8 linecolor rgb " +
                    std::string(legend[i].second) + " title '" + legend[i].first + "'");
  }
  return script + "plot " + joined(parts) + "\n";
}

}  // namespace

void plot_histories(const HistoryPlot& plot, const std::filesystem::path& path) {
  require(!plot.axes.empty() && plot.axes.size() <= most_panels, "one to six axes are drawn");
  require(plot.sample_rate_hz > 0, "a sample rate that is not positive");
  Index longest = 0;
  for (const AxisHistory& axis : plot.axes) {
    longest = std::max({longest, axis.floor.size(), axis.passive.size(), axis.active.size()});
  }
  std::string script = panel_frame(plot.title);
  script +=
      "set xrange [0:" + plot_number(static_cast<double>(longest) / plot.sample_rate_hz) + "]\n";
  const double height = 0.81 / static_cast<double>(plot.axes.size());
  for (std::size_t p = 0; p < plot.axes.size(); ++p) {
    const double top = 0.93 - height * static_cast<double>(p);
    const bool lowest = p + 1 == plot.axes.size();
    script += margins(0.085, 0.975, top - height + 0.03, top);
    script += "set ylabel " + plot_text(plot.axes[p].axis + "  (mm/s²)") + " noenhanced\n";
    script += lowest ? "set format x '%g'\nset xlabel 'time (s)'\n" : "set format x ''\n";
    script += history_panel(plot.axes[p], std::to_string(p), plot.sample_rate_hz);
    if (p == 0) script += once_only();
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

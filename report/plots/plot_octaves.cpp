#include <algorithm>
#include <cmath>

#include "core/numerics/infinity.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"
#include "report/plots/plots.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double um_per_m = 1e6;

struct Range {
  double lowest = infinity;
  double highest = 0;

  void include(const VectorXd& values, double scale) {
    for (const double value : values) {
      if (!(value > 0)) continue;
      lowest = std::min(lowest, scale * value);
      highest = std::max(highest, scale * value);
    }
  }
};

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
/// every: how many criteria have one name between them.
std::string criteria_lines(const Range& range, int every) {
  std::string block = "$criteria << end_of_data\n", labels;
  int tag = 10, n = 0;
  for (const VibrationCriterion& criterion : vibration_criteria()) {
    for (const OctaveBand& band : third_octave_bands()) {
      if (!criterion.applies(band.centre_hz)) continue;
      block += plot_number(band.centre_hz) + " " +
               plot_number(um_per_m * criterion.limit(band.centre_hz)) + "\n";
    }
    block += "\n";
    const double end = um_per_m * criterion.velocity;
    if (end < range.lowest || end > range.highest || n++ % every != 0) continue;
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
  const double width = 0.89 / static_cast<double>(columns),
               height = 0.83 / static_cast<double>(rows);
  const double left = 0.1 + width * static_cast<double>(column);
  const double top = 0.92 - height * static_cast<double>(row);
  return {.left = left,
          .right = left + width - 0.02,
          .bottom = top - height + (rows > 1 ? 0.08 : 0.07),
          .top = top - 0.03,
          .leftmost = column == 0,
          .lowest = p + columns >= n};
}

/// How many criteria, a factor of two apart, it takes for names that stand clear of each other.
int names_apart(const Range& range, std::size_t n_panels) {
  constexpr double line = 0.019;  // of the picture's height, of letters of this size
  const PanelPlace place = side_by_side(0, n_panels);
  const double octave = (place.top - place.bottom) / std::log2(range.highest / range.lowest);
  return std::max(1, static_cast<int>(std::ceil(line / octave)));
}

/// The three signals of a panel, in the order of the legend.
struct BandSignal {
  const char* name;
  VectorXd AxisBands::*velocity;
  const char* colour;
  int point_type;
};
constexpr BandSignal band_signals[] = {{"floor", &AxisBands::floor, floor_colour, 5},
                                       {"frame, passive", &AxisBands::passive, passive_colour, 7},
                                       {"frame, active", &AxisBands::active, active_colour, 9}};

std::string style_of(const BandSignal& signal) {
  return " with linespoints linewidth 3 pointtype " + std::to_string(signal.point_type) +
         " pointsize 1.1 linecolor rgb " + signal.colour;
}

constexpr const char* criteria_style = " with lines linewidth 1.2 linecolor rgb '#A0A0A0'";

bool any_has(const std::vector<AxisBands>& axes, const BandSignal& signal) {
  return std::any_of(axes.begin(), axes.end(),
                     [&](const AxisBands& axis) { return (axis.*signal.velocity).size() > 0; });
}

std::string octave_panel(const AxisBands& axis, const std::string& suffix,
                         const PanelPlace& place) {
  std::string script = margins(place.left, place.right, place.bottom, place.top);
  script += "set title " + plot_text(axis.axis) + " noenhanced font ',20' offset 0,-0.6\n";
  script += place.leftmost ? "set format y '%g'\n" : "set format y ''\n";
  script += place.lowest ? "set xlabel 'frequency (Hz)'\n" : "unset xlabel\n";
  std::vector<std::string> parts = {std::string("$criteria using 1:2") + criteria_style};
  for (const BandSignal& signal : band_signals) {
    const VectorXd& velocity = axis.*signal.velocity;
    if (velocity.size() == 0) continue;
    const std::string block = "bands_" + std::to_string(signal.point_type) + "_" + suffix;
    script += plot_data(block, band_table(velocity));
    parts.push_back("$" + block + " using 1:2" + style_of(signal));
  }
  return script + "plot " + joined(parts) + "\n";
}

}  // namespace

void plot_third_octaves(const OctavePlot& plot, const std::filesystem::path& path) {
  require(!plot.axes.empty() && plot.axes.size() <= most_panels, "one to six axes are drawn");
  Surroundings around{
      .title = plot.title, .left_label = "rms velocity in one-third octaves (µm/s)", .legend = {}};
  Range range;
  for (const BandSignal& signal : band_signals) {
    if (!any_has(plot.axes, signal)) continue;
    around.legend.push_back("keyentry" + style_of(signal) + " title " + plot_text(signal.name));
    for (const AxisBands& axis : plot.axes) range.include(axis.*signal.velocity, um_per_m);
  }
  // All criteria stay in the picture, whatever the data.
  range.lowest = std::min(range.lowest, 0.78) / 1.8;
  range.highest = std::max(range.highest, 60.0) * 1.8;
  std::string script = surround(around) + frequency_axis(lowest_octave_hz, highest_octave_hz, "");
  script += "set xtics (1, 2, 5, 10, 20, 50)\nset logscale y 10\nset mytics 10\nset yrange [" +
            plot_number(range.lowest) + ":" + plot_number(range.highest) + "]\n" +
            criteria_lines(range, names_apart(range, plot.axes.size()));
  for (std::size_t p = 0; p < plot.axes.size(); ++p) {
    script += octave_panel(plot.axes[p], std::to_string(p), side_by_side(p, plot.axes.size()));
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

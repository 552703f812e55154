#include "report/plots/plot_fit.hpp"

#include <algorithm>

#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe::report {

namespace {

constexpr const char* read_style = " with points pointtype 7 pointsize 1.1 linecolor rgb 'black'";
constexpr const char* fitted_style = " with lines linewidth 3 linecolor rgb '#0072B2'";
constexpr const char* other_style =
    " with lines linewidth 2 dashtype (4,6) linecolor rgb '#D55E00'";

}  // namespace

void plot_fit(const FitPlot& plot, const std::filesystem::path& path) {
  require(plot.frequencies_hz.size() > 1, "fewer than two frequencies");
  require(!plot.panels.empty(), "no panels");
  const auto n = std::min(plot.panels.size(), most_panels);
  const std::size_t n_columns = n > 1 ? 2 : 1, n_rows = (n + n_columns - 1) / n_columns;
  std::string script = surround(
      {.title = plot.title,
       .left_label = plot.left_label,
       .legend = {legend_entry(read_style, "measured"), legend_entry(fitted_style, plot.fitted),
                  legend_entry(other_style, plot.other)}});
  for (std::size_t i = 0; i < n; ++i) {
    const FitPanel& panel = plot.panels[i];
    require(panel.measured.size() == plot.frequencies_hz.size(), "a curve of another length");
    const auto row = static_cast<double>(i / n_columns),
               column = static_cast<double>(i % n_columns);
    const double width = 0.87 / static_cast<double>(n_columns),
                 height = 0.75 / static_cast<double>(n_rows), left = 0.09 + width * column,
                 top = 0.92 - height * row;
    Eigen::MatrixXd table(plot.frequencies_hz.size(), 4);
    table << plot.frequencies_hz, 20 * panel.measured.array().log10().matrix(),
        20 * panel.fitted.array().log10().matrix(), 20 * panel.other.array().log10().matrix();
    const std::string name = "panel" + std::to_string(i);
    const bool lowest = i + n_columns >= n;
    script +=
        margins(left, left + width - 0.05, top - height + 0.06, top - 0.02) +
        frequency_axis(plot.frequencies_hz(0), plot.frequencies_hz(table.rows() - 1),
                       lowest ? "frequency (Hz)" : "") +
        "set ytics 20\nset yrange [*:*]\nset label 1 " + plot_text(panel.title) +
        " noenhanced at graph 0.02, graph 0.92\n" + plot_data(name, table) + "plot " +
        joined({"$" + name + " using 1:4" + other_style, "$" + name + " using 1:3" + fitted_style,
                "$" + name + " using 1:2" + read_style}) +
        "\n";
  }
  run_gnuplot(script, path);
}

}  // namespace stillframe::report

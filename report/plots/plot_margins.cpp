#include "report/plots/plot_margins.hpp"

#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe::report {

void plot_margins(const MarginPlot& plot, const std::filesystem::path& path) {
  std::string script = frame_style() + margins(0.1, 0.965, 0.2, 0.92);
  script += "set key at screen 0.53,0.055 maxrows 2\nset title " + plot_text(plot.title) +
            " noenhanced font ',22'\n";
  script += "set xlabel 'disk margin of the feedback (1)'\nset ylabel " +
            plot_text(plot.quantity + " (dB)") + "\nset xrange [0:*]\n";
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    const MarginCurve& curve = plot.curves[i];
    require(curve.disk.size() == curve.level_db.size(), curve.label + ": disk and level_db");
    if (curve.disk.size() == 0) continue;
    Eigen::MatrixXd table(curve.disk.size(), 2);
    table << curve.disk, curve.level_db;
    const std::string name = "curve_" + std::to_string(i);
    script += plot_data(name, table);
    parts.push_back("$" + name + " using 1:2 with linespoints linewidth 3 pointsize 1.5 title " +
                    plot_text(curve.label));
  }
  require(!parts.empty(), "no curve");
  script += "set arrow from " + plot_number(plot.wished_disk) + ", graph 0 to " +
            plot_number(plot.wished_disk) +
            ", graph 1 nohead dashtype (12,6) linewidth 2 linecolor rgb 'black'\n";
  run_gnuplot(script + "plot " + joined(parts) + "\n", path);
}

}  // namespace stillframe::report

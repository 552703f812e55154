#include "report/plots/plot_style.hpp"

#include <cmath>
#include <stdexcept>

#include "report/plots/gnuplot.hpp"

namespace stillframe::report {

std::string frame_style() {
  return "set border 3 linecolor rgb '#404040' linewidth 1.5\n"
         "set tics nomirror out scale 0.6\n"
         "set grid xtics ytics linetype 1 linecolor rgb '#DCDCDC' linewidth 1\n"
         "set key noenhanced Left reverse horizontal center center samplen 2.5\n";
}

std::string margins(double left, double right, double bottom, double top) {
  return "set lmargin at screen " + plot_number(left) + "\nset rmargin at screen " +
         plot_number(right) + "\nset bmargin at screen " + plot_number(bottom) +
         "\nset tmargin at screen " + plot_number(top) + "\n";
}

std::string frequency_axis(double lowest_hz, double highest_hz, const std::string& title) {
  const std::string label = title.empty() ? "" : "set xlabel " + plot_text(title) + "\n";
  // Over more than five decades the labels of 2 and 5 would meet.
  const bool all = highest_hz < 1e5 * lowest_hz;
  std::string tics;
  for (int i = static_cast<int>(std::floor(std::log10(lowest_hz)));
       i <= static_cast<int>(std::ceil(std::log10(highest_hz))); ++i) {
    for (const char* step : {"1e", "2e", "5e"}) {
      if (all || step[0] == '1')
        tics += (tics.empty() ? "" : ", ") + std::string(step) + std::to_string(i);
    }
  }
  return "set logscale x 10\nset xrange [" + plot_number(lowest_hz) + ":" +
         plot_number(highest_hz) + "]\nset xtics (" + tics + ")\n" + label;
}

std::string legend_entry(const std::string& style, const std::string& title) {
  return "keyentry" + style + " title " + plot_text(title);
}

std::string surround(const Surroundings& around) {
  return frame_style() + "set multiplot\n" + margins(0.09, 0.965, 0.1, 0.9) +
         "unset border\nunset tics\nunset grid\nset xrange [0:1]\nset yrange [0:1]\n" +
         "set label 1 " + plot_text(around.title) +
         " at screen 0.5,0.965 center noenhanced font ',22'\n" + "set label 2 " +
         plot_text(around.left_label) + " at screen 0.02,0.53 center rotate noenhanced\n" +
         "set key at screen 0.53,0.03 maxrows 1\nplot NaN notitle, \\\n  " + joined(around.legend) +
         "\nunset key\nunset label\nset xtics\nset ytics\nset autoscale\n" + frame_style() +
         "unset key\n";
}

std::string joined(const std::vector<std::string>& parts) {
  std::string list;
  for (const std::string& part : parts) list += (list.empty() ? "" : ", \\\n  ") + part;
  return list;
}

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("plots: " + what);
}

}  // namespace stillframe::report

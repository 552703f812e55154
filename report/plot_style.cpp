#include "report/plot_style.hpp"

#include <stdexcept>

#include "report/gnuplot.hpp"

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
  return "set logscale x 10\nset xrange [" + plot_number(lowest_hz) + ":" +
         plot_number(highest_hz) +
         "]\nset xtics (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)\n" + label;
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

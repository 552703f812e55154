// Plant and Simbody side by side: two rigid scenes, the same held inputs, several tolerances each,
// interleaved, medians of the wall time. Errors are relative, against the finest run of the other
// program where the two finest runs agree better than that.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <vector>

#include "bench/machine.hpp"
#include "bench/simbody/plant_run.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "report/table.hpp"

namespace {

using namespace stillframe;
using simbody::Method;
using simbody::Run;

struct Contender {
  std::string name;
  double tolerance;
  std::function<Run(double)> run;
  double error = 0;
  std::vector<double> seconds = {};
  double median() {
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    return seconds[seconds.size() / 2];
  }
};

/// Time at an error, between two tolerances by a straight line in logarithms; NaN outside.
double time_at(double error, std::vector<std::pair<double, double>> points) {
  std::sort(points.begin(), points.end());
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const auto [e_0, t_0] = points[i];
    const auto [e_1, t_1] = points[i + 1];
    if (e_0 > error || e_1 < error) continue;
    const double share = std::log(error / e_0) / std::log(e_1 / e_0);
    return t_0 * std::pow(t_1 / t_0, share);
  }
  return std::nan("");
}

using SimbodyRun = std::function<Run(Method, double)>;
using PlantRun = std::function<Run(double)>;

void compare(const std::string& title, const SimbodyRun& other, const PlantRun& plant,
             double floor_seconds, Eigen::Index samples, int repeats) {
  const Run fine_other = other(Method::runge_kutta_merson, 1e-14), fine_plant = plant(1e-13);
  std::cout << "\n"
            << title << ": finest runs differ by "
            << report::cell("%.1e", simbody::difference(fine_other, fine_plant)) << "\n";
  std::vector<Contender> contenders;
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10}) {
    contenders.push_back({"stillframe", tolerance, plant});
  }
  // Simbody's accuracy is absolute for motions below 1.
  for (const Method method : {Method::runge_kutta_merson, Method::runge_kutta_feldberg}) {
    for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13}) {
      contenders.push_back({simbody::name_of(method), tolerance,
                            [&other, method](double accuracy) { return other(method, accuracy); }});
    }
  }
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (Contender& contender : contenders) {
      const Run run = contender.run(contender.tolerance);
      contender.seconds.push_back(run.seconds);
      // Each against the other program, so that no method is measured by itself.
      const bool ours = contender.name == "stillframe";
      contender.error = simbody::difference(run, ours ? fine_other : fine_plant);
    }
  }
  report::Table table({"program", "tolerance", "relative error", "times real time", "us a sample"},
                      1);
  std::vector<std::pair<double, double>> ours, best_other;
  for (Contender& contender : contenders) {
    const double time = contender.median();
    table.add({contender.name, report::cell("%g", contender.tolerance),
               report::cell("%.1e", contender.error), report::cell("%.1f", floor_seconds / time),
               report::cell("%.1f", 1e6 * time / static_cast<double>(samples))});
    if (contender.name == "stillframe") ours.emplace_back(contender.error, time);
    if (contender.name == simbody::name_of(Method::runge_kutta_merson)) {
      best_other.emplace_back(contender.error, time);
    }
  }
  std::cout << table.print() << std::flush;
  for (const double error : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
    const double a = time_at(error, ours), b = time_at(error, best_other);
    if (a == a && b == b) {
      std::cout << report::cell("at error %.0e ", error)
                << report::cell("Simbody (Merson) takes %.2f times as long\n", b / a);
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  using namespace stillframe;
  using namespace stillframe::simbody;
  const std::filesystem::path top = STILLFRAME_SOURCE_DIR;
  const int repeats = argc > 1 ? std::atoi(argv[1]) : 5;
  std::cout << machine_line(STILLFRAME_FLAGS) << "\n";
  constexpr Eigen::Index samples = 400;
  const Scene frame = read_scene(top / "config/scenes/metrology_frame.yaml");
  const Eigen::MatrixXd floor = sines(6, samples, 1e-3, 1, 1, 100);
  compare(
      "Metrology frame",
      [&](Method m, double a) { return simbody_run(body_on_springs(frame), floor, m, a); },
      [&](double t) { return plant_run(frame, floor, t); }, 1e-3 * samples, samples, repeats);
  // Over a longer time the swinging multiplies all errors until nothing can be compared.
  constexpr Eigen::Index swings = 100;
  const Scene pendulum = read_scene(top / "bench/simbody/pendulum.yaml");
  const double rate = pendulum.controller->sample_rate_hz;
  const Eigen::MatrixXd shaking = sines(3, swings, 1 / rate, 10, 0.5, 5);
  compare(
      "Double pendulum",
      [&](Method m, double a) { return simbody_run(link_chain(pendulum), shaking, m, a); },
      [&](double t) { return plant_run(pendulum, shaking, t); }, swings / rate, swings, repeats);
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}

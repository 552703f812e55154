// Free motion of the undamped frame for very long: the energy is kept to the tolerance, without a
// drift beyond that of rounding.
#include <cmath>
#include <iostream>

#include "bench/machine.hpp"
#include "bench/plant_run.hpp"
#include "core/cli/command.hpp"
#include "core/errors/formatted.hpp"
#include "report/table.hpp"
#include "tests/plant_sim/motion_rig.hpp"

namespace {

using namespace stillframe;

constexpr double slowest_hz = 13.9055;

struct Options {
  double periods = 1e6, tolerance = 1e-8, push_n = 1000, part_s = 1e-3;
  std::string method = method_name(PlantMethod::exponential);
};

/// Those whose state the rig knows the energy of.
const std::vector<std::string> methods{method_name(PlantMethod::exponential),
                                       method_name(PlantMethod::dormand_prince)};

void run(const Options& options) {
  const PlantMethod method = method_named(options.method).value();
  Scene scene = test::with_method(test::frame_scene(), method, options.tolerance);
  test::MotionRig rig(scene, method, Eigen::MatrixXd::Zero(6, 1));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(6);
  if (!rig.hold(options.push_n * test::noise(6, 1, 8), 5e-3)) throw std::runtime_error("the push");
  const double start = rig.energy();
  const auto n = static_cast<std::int64_t>(options.periods / slowest_hz / options.part_s);
  std::cout << machine_line(STILLFRAME_FLAGS) << "\n"
            << "energy after the push " << formatted("%.6g J", start) << "\n";
  report::Table table({"periods", "parts", "energy / first - 1", "largest on the way", "cpu s"}, 0);
  double largest = 0, next = 1;
  const double begin = thread_seconds();
  for (std::int64_t k = 1; k <= n; ++k) {
    if (!rig.hold(none, options.part_s)) throw std::runtime_error("the motion cannot go on");
    if (k % 97 != 0 && k != n) continue;  // any phase of the motion
    const double drift = rig.energy() / start - 1;
    largest = std::max(largest, std::abs(drift));
    const double periods = static_cast<double>(k) * options.part_s * slowest_hz;
    if (periods < next && k != n) continue;
    table.add({formatted("%.3g", periods), std::to_string(k), formatted("%.2e", drift),
               formatted("%.2e", largest), formatted("%.1f", thread_seconds() - begin)});
    next *= 10;
  }
  std::cout << table.print();
}

}  // namespace

int main(int argc, char** argv) {
  cli::Command app("Energy of free motion of the undamped frame after a push of all legs.",
                   "bench_plant_energy");
  Options options;
  app.option("--periods", options.periods, "Of the slowest mode")
      .check(cli::number_between(1.0, 1e9))
      .show_default();
  app.option("--tolerance", options.tolerance, "Of the integration, relative")
      .check(cli::number_between(1e-14, 1e-2))
      .show_default();
  app.option("--part", options.part_s, "Length of the parts that are stepped, s")
      .check(cli::number_between(1e-5, 1e-1))
      .show_default();
  app.option("--method", options.method, "Of the integration")
      .check(cli::one_of(methods))
      .show_default();
  app.option("--push", options.push_n, "N in each leg, at most")
      .check(cli::positive_number())
      .show_default();
  try {
    if (const auto code = app.parse(argc, argv)) return *code;
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_plant_energy: " << error.what() << "\n";
    return 4;
  }
}

// How often 95 % bands of identified responses hold what is predicted, over noisy runs of the
// nonlinear plant in closed loop: noise of the force sensors, which moves the frame, and noise of
// the floor accelerometers, which spoils what the response is divided by.
#include <atomic>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/cli/command.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/loop_design.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor_motion.hpp"
#include "report/identification/comparison.hpp"
#include "report/identification/confidence.hpp"
#include "report/identification/multisine.hpp"
#include "report/table.hpp"
#include "tools/run/closed_loop.hpp"

namespace {

using namespace stillframe;
using Eigen::Index;
using Eigen::MatrixXd;

const std::filesystem::path config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";

struct Options {
  int runs = 200, threads = 2;
  double sensor_noise = 1e-2, floor_noise = 1e-6, level = 0.95;
  bool json = false;
};

/// How often something held.
struct Tally {
  std::int64_t n = 0, held = 0;
  void add(bool holds) {
    ++n;
    held += holds ? 1 : 0;
  }
  double share() const { return static_cast<double>(held) / static_cast<double>(n); }
};

struct Result {
  Tally entries, values, compared;
  double largest_db = 0;  ///< of those that are compared
};

class Study {
 public:
  explicit Study(const Options& options)
      : options_(options),
        design_(judge::make_loop_design(config / "scenes/metrology_frame.yaml", std::nullopt)),
        spec_(floor::read_floor_block(YamlReader::from_file(config / "floors/multisine.yaml"),
                                      design_.gains.sample_rate_hz,
                                      floor_input_names(design_.scene))),
        plan_(std::get<MultisinePlan>(spec_.kind)) {
    for (const double f : plan_.frequencies_hz) {
      exact_.push_back(transfer(design_.closed, two_pi * f));
    }
    sigma_ = report::singular_values(exact_);
  }

  Result run() {
    std::vector<std::jthread> threads;
    for (int t = 0; t < options_.threads; ++t) threads.emplace_back([this] { work(); });
    threads.clear();
    if (!failure_.empty()) throw std::runtime_error(failure_);
    return result_;
  }

 private:
  void work() {
    for (int run = next_++; run < options_.runs; run = next_++) {
      try {
        judge(measure(static_cast<std::uint64_t>(run) + 1));
      } catch (const std::exception& error) {
        const std::lock_guard lock(mutex_);
        failure_ = error.what();
        return;
      }
    }
  }

  report::FrequencyResponse measure(std::uint64_t seed) const {
    Scene scene = design_.scene;
    if (options_.sensor_noise > 0) {
      scene.instruments.force_sensors = ForceSensorErrors{};
      scene.instruments.force_sensors->noise = options_.sensor_noise;
      scene.instruments.force_sensors->seed = seed;
    }
    if (options_.floor_noise > 0) {
      scene.instruments.floor_sensors =
          FloorSensorErrors{.noise = options_.floor_noise, .seed = seed + 1'000'000};
    }
    tools::ClosedLoop loop(scene, design_.gains, floor::make_floor_source(spec_), 1, true);
    const Index n = plan_.n_samples() + 1, n_w = design_.loop.n_w, n_y = design_.loop.n_y;
    MatrixXd inputs(n, n_w), outputs(n, n_y);
    for (Index k = 0; k < n; ++k) {
      if (const auto reason = loop.step(); !reason.empty()) throw std::runtime_error(reason);
      const auto& read = loop.measurement();
      inputs.row(k) = Eigen::Map<const Eigen::RowVectorXd>(read.floor_acceleration.data(), n_w);
      outputs.row(k) = Eigen::Map<const Eigen::RowVectorXd>(read.frame_acceleration.data(), n_y);
    }
    return report::identify(plan_, inputs, outputs, 1);
  }

  void judge(const report::FrequencyResponse& response) {
    Result one;
    const report::Bands bands = report::singular_value_bands(response, options_.level);
    const auto compared =
        report::compare(response, report::singular_value_bands(response, 0.95), sigma_);
    for (Index l = 0; l < response.n_frequencies(); ++l) {
      const auto at = static_cast<std::size_t>(l);
      const MatrixXd distance = (response.T[at] - exact_[at]).cwiseAbs();
      const MatrixXd radii = report::entry_radii(response, l, options_.level);
      for (Index i = 0; i < distance.size(); ++i) {
        one.entries.add(distance.reshaped()(i) <= radii.reshaped()(i));
      }
      for (Index i = 0; i < sigma_.cols(); ++i) {
        const bool holds = bands.lower(l, i) <= sigma_(l, i) && sigma_(l, i) <= bands.upper(l, i);
        one.values.add(holds);
        if (!std::isnan(compared.difference_db(l, i))) one.compared.add(holds);
      }
    }
    one.largest_db = compared.largest_db;
    const std::lock_guard lock(mutex_);
    for (auto [sum, part] :
         {std::pair(&result_.entries, one.entries), std::pair(&result_.values, one.values),
          std::pair(&result_.compared, one.compared)}) {
      sum->n += part.n;
      sum->held += part.held;
    }
    result_.largest_db = std::max(result_.largest_db, one.largest_db);
  }

  Options options_;
  judge::LoopDesign design_;
  floor::FloorSpec spec_;
  MultisinePlan plan_;
  std::vector<Eigen::MatrixXcd> exact_;
  MatrixXd sigma_;
  std::atomic<int> next_{0};
  std::mutex mutex_;
  std::string failure_;
  Result result_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  cli::Command app("Coverage of confidence bands over noisy runs of the nonlinear closed loop");
  app.option("--runs", options.runs, "Runs, a seed each").check(cli::positive_number());
  app.option("--threads", options.threads, "At once").check(cli::positive_number());
  app.option("--sensor-noise", options.sensor_noise, "Of the force sensors, N/sqrt(Hz)");
  app.option("--floor-noise", options.floor_noise, "Of the floor accelerometers, m/s^2/sqrt(Hz)");
  app.option("--level", options.level, "Of the bands").check(cli::number_between(0.5, 0.999));
  app.flag("--json", options.json, "Print JSON");
  if (const auto code = app.parse(argc, argv)) return *code;
  try {
    const Result result = Study(options).run();
    if (options.json) {
      std::cout << nlohmann::json{{"runs", options.runs},
                                  {"level", options.level},
                                  {"entries", result.entries.share()},
                                  {"singular_values", result.values.share()},
                                  {"compared", result.compared.share()},
                                  {"n_entries", result.entries.n},
                                  {"n_compared", result.compared.n},
                                  {"largest_db", result.largest_db}}
                       .dump(2)
                << "\n";
      return 0;
    }
    report::Table table({"bands of", "held", "of"}, 1);
    const auto add = [&](const char* what, const Tally& tally) {
      table.add({what, formatted("%.4f", tally.share()), std::to_string(tally.n)});
    };
    add("entries of T", result.entries);
    add("singular values", result.values);
    add("those that are compared", result.compared);
    std::cout << formatted("%d runs, %g %% bands, %g N/sqrt(Hz) and %g m/s^2/sqrt(Hz)\n",
                           options.runs, 100 * options.level, options.sensor_noise,
                           options.floor_noise)
              << table.print()
              << formatted("largest error of a singular value that is compared: %.4f dB\n",
                           result.largest_db);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_band_coverage: " << error.what() << "\n";
    return 4;
  }
}

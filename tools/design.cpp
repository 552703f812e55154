#include <algorithm>
#include <fstream>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>

#include "controller/start_check.hpp"
#include "core/frequency_response.hpp"
#include "core/yaml/input_error.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/loop_design.hpp"
#include "tools/matrix_table.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr double table_frequencies_hz[] = {1, 2, 5, 10, 20, 50, 100};

struct Options {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, out;
  bool json = false;
};

const char* word(GainOrder order) { return order == GainOrder::exact ? "exact" : "deck"; }

Eigen::VectorXcd poles(const LoopDesign& design) {
  return closed_loop_poles(design.loop.legs, design.loop.gains,
                           2 * std::numbers::pi * design.scene.controller->target_hz);
}

void print_transfer(const LoopDesign& design) {
  std::cout << "Floor to frame, largest singular value\n";
  report::Table table({"Hz", "open", "closed", "sampled", "open dB", "sampled dB"}, 0);
  for (const double f : table_frequencies_hz) {
    const double omega = 2 * std::numbers::pi * f;
    const double open = singular_values(design.loop.open({0.0, omega}))(0);
    const double closed = singular_values(design.loop.closed({0.0, omega}))(0);
    const double sampled = singular_values(transfer(design.closed, omega))(0);
    table.add({report::cell("%g", f), report::cell("%.4e", open), report::cell("%.4e", closed),
               report::cell("%.4e", sampled), report::cell("%.1f", 20 * std::log10(open)),
               report::cell("%.1f", 20 * std::log10(sampled))});
  }
  std::cout << table.print();
}

/// What the chosen order of the two matrices does, in words.
void print_poles(const LoopDesign& design) {
  const SceneController& block = *design.scene.controller;
  const double omega_d = 2 * std::numbers::pi * block.target_hz;
  const Eigen::VectorXcd all = poles(design);
  double lowest = std::numeric_limits<double>::infinity(), highest = 0, largest_real = -lowest;
  int slow = 0;
  for (const auto& pole : all) {
    largest_real = std::max(largest_real, pole.real());
    // The law's own poles sit at about the leak, far below the target.
    if (std::abs(pole) < 0.1 * omega_d) {
      ++slow;
      continue;
    }
    lowest = std::min(lowest, std::abs(pole) / omega_d);
    highest = std::max(highest, std::abs(pole) / omega_d);
  }
  std::cout << report::cell(
      "Continuous closed loop: %td poles at %.4f to %.4f omega_d, %d slow ones of the leak, "
      "largest real part %.4g 1/s\n",
      all.size() - slow, lowest, highest, slow, largest_real);
}

void print_page(const LoopDesign& design) {
  const SceneController& block = *design.scene.controller;
  std::cout
      << design.scene.title << "\n"
      << report::cell(
             "Target: omega_d = 2 pi %g rad/s, zeta = %g, order %s (X = %s / omega_d^2), leak %g "
             "Hz\n",
             block.target_hz, block.damping_ratio, word(block.order),
             block.order == GainOrder::exact ? "K M^-1" : "M^-1 K", block.leak_hz)
      << report::cell(
             "Sampled at %g Hz, a command takes effect %d sample(s) after its measurement, lead %g "
             "sample(s)\n\n",
             block.sample_rate_hz, block.delay_samples, block.lead_samples);
  std::cout << matrix_table("K_P (1)", design.gains.K_P)
            << matrix_table("K_I (1/s)", design.gains.K_I) << "\n";
  print_poles(design);
  std::cout << report::cell("Sampled closed loop: spectral radius %.9f\n\n", design.radius);
  print_transfer(design);
}

void print_json(const LoopDesign& design) {
  Eigen::VectorXd frequencies(std::size(table_frequencies_hz));
  Json open = Json::array(), closed = Json::array(), sampled = Json::array();
  for (Index i = 0; i < frequencies.size(); ++i) {
    frequencies(i) = table_frequencies_hz[i];
    const double omega = 2 * std::numbers::pi * frequencies(i);
    open.push_back(to_json(singular_values(design.loop.open({0.0, omega}))));
    closed.push_back(to_json(singular_values(design.loop.closed({0.0, omega}))));
    sampled.push_back(to_json(singular_values(transfer(design.closed, omega))));
  }
  print({{"scene", design.scene.title},
         {"scene_hash", design.scene.hash},
         {"order", word(design.scene.controller->order)},
         {"legs", design.gains.legs},
         {"K_P", to_json(design.gains.K_P)},
         {"K_I", to_json(design.gains.K_I)},
         {"leak_hz", design.gains.leak_hz},
         {"closed_loop_poles", to_json(poles(design))},
         {"spectral_radius", design.radius},
         {"frequencies_hz", to_json(frequencies)},
         {"singular_values", open},
         {"closed_singular_values", closed},
         {"sampled_singular_values", sampled}});
}

void write_gains(const controller::Gains& gains, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << to_yaml(gains);
  file.close();
  if (!file) throw InputError(path.string() + ": cannot be written");
}

int run(const Options& options) {
  const LoopDesign design = make_loop_design(options.scene, options.controller);
  options.json ? print_json(design) : print_page(design);
  controller::require_stable(design.gains);
  if (options.out) write_gains(design.gains, *options.out);
  return exit_done;
}

}  // namespace

void add_design(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("design",
                                      "Decoupled PI force-feedback gains K_P and K_I of a scene, "
                                      "and what the closed loop then does");
  verb->add_option("scene", options->scene, "Scene file (YAML) with a controller block")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--controller", options->controller,
                   "Controller block that replaces the scene's")
      ->type_name("FILE");
  verb->add_option("--out", options->out, "Write the gains file that stillframe-controller reads")
      ->type_name("FILE");
  verb->add_flag(
      "--json", options->json,
      "Print JSON: K_P, K_I, closed_loop_poles [re, im] in rad/s, spectral_radius, frequencies_hz, "
      "singular_values (open), closed_singular_values, sampled_singular_values");
  verb->footer(
      "Gains whose sampled closed loop is not stable are printed and refused: exit code 3, no file "
      "written.");
  verb->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

#include "core/cli/numbers.hpp"
#include "core/frequency_response.hpp"
#include "core/linear/frequency_sweep.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/state_space.hpp"
#include "core/yaml/input_error.hpp"
#include "report/plots/plots.hpp"
#include "report/table.hpp"
#include "tools/design_warnings.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/loop_design.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct Options {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, plot;
  std::optional<double> from_hz, to_hz;
  int points = 50;
  bool json = false;
};

/// A row a frequency. With a controller, closed is the loop that runs, NaN above half its rate, and
/// continuous its law without sampling, delay and instruments.
struct Curves {
  Eigen::VectorXd frequencies_hz;
  Eigen::MatrixXd open, closed, continuous;
};

Eigen::MatrixXd rows_of(const Eigen::VectorXd& frequencies_hz,
                        const std::function<Eigen::MatrixXcd(double omega)>& response) {
  Eigen::MatrixXd rows;
  for (Index i = 0; i < frequencies_hz.size(); ++i) {
    const Eigen::VectorXd values =
        singular_values(response(2 * std::numbers::pi * frequencies_hz(i)));
    if (i == 0) rows.resize(frequencies_hz.size(), values.size());
    rows.row(i) = values.transpose();
  }
  return rows;
}

/// The state space of the scene about its operating point.
StateSpace open_system(const Scene& scene) {
  if (scene.inputs.empty() || scene.outputs.empty()) {
    throw InputError(scene.file +
                     ": singular values need at least one of 'inputs' and of 'outputs'");
  }
  return state_space(linearise(make_model(scene), scene.inputs, scene.outputs));
}

Curves without_controller(const StateSpace& system, const Eigen::VectorXd& frequencies_hz,
                          Patience& patience) {
  FrequencySweep sweep(system);
  SingularValues decomposition(sweep.n_outputs(), sweep.n_inputs());
  constexpr Index batch = 64;  // the decomposition takes several at once
  std::vector<Eigen::MatrixXcd> G(batch, Eigen::MatrixXcd(sweep.n_outputs(), sweep.n_inputs()));
  const Index n = frequencies_hz.size();
  Eigen::MatrixXd values(std::min(sweep.n_outputs(), sweep.n_inputs()), n);
  for (Index begin = 0; begin < n; begin += batch) {
    patience.now("singular values", 100.0 * static_cast<double>(begin) / static_cast<double>(n));
    const Index count = std::min(batch, n - begin);
    for (Index i = 0; i < count; ++i) {
      const double omega = 2 * std::numbers::pi * frequencies_hz(begin + i);
      sweep.evaluate({0.0, omega}, G[static_cast<size_t>(i)]);
    }
    decomposition.compute(G.data(), count, values.middleCols(begin, count));
  }
  return {frequencies_hz, values.transpose(), {}, {}};
}

Curves with_controller(const LoopDesign& design, const Eigen::VectorXd& frequencies_hz) {
  Curves curves{
      frequencies_hz,
      rows_of(frequencies_hz,
              [&](double omega) {
                return design.loop.open({0.0, omega});
              }),
      rows_of(frequencies_hz, [&](double omega) { return transfer(design.closed, omega); }),
      rows_of(frequencies_hz, [&](double omega) {
        return design.loop.closed({0.0, omega});
      })};
  for (Index i = 0; i < frequencies_hz.size(); ++i) {
    // Half the rate itself is one of them, but for the rounding of its logarithm.
    if (frequencies_hz(i) <= (1 + 1e-9) * design.gains.sample_rate_hz / 2) continue;
    curves.closed.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return curves;
}

void print_table(const std::string& title, const Curves& curves, double sample_rate_hz) {
  const bool loop = curves.closed.size() > 0;
  std::cout << title << ": singular values, largest first"
            << (loop
                    ? report::cell("; closed: the loop that runs, sampled at %g Hz", sample_rate_hz)
                    : "")
            << "\n";
  std::vector<std::string> header{"Hz"};
  for (const char* kind : {"open", "closed"}) {
    if (!loop && kind == std::string("closed")) continue;
    for (Index i = 0; i < curves.open.cols(); ++i)
      header.push_back(report::cell("%s %td", kind, i + 1));
  }
  report::Table table(header, 0);
  for (Index f = 0; f < curves.frequencies_hz.size(); ++f) {
    std::vector<std::string> row{report::cell("%.4g", curves.frequencies_hz(f))};
    for (const auto* values : {&curves.open, &curves.closed}) {
      if (values->size() == 0) continue;
      for (Index i = 0; i < values->cols(); ++i) {
        const double value = (*values)(f, i);
        row.push_back(std::isnan(value) ? "-" : report::cell("%.4e", value));
      }
    }
    table.add(row);
  }
  std::cout << table.print();
}

void print_json(const std::string& title, const Curves& curves) {
  Json document{{"scene", title},
                {"frequencies_hz", to_json(curves.frequencies_hz)},
                {"singular_values", to_json(curves.open)}};
  if (curves.closed.size() > 0) {
    document["closed_singular_values"] = to_json(curves.closed);
    document["continuous_singular_values"] = to_json(curves.continuous);
  }
  print(document);
}

void plot(const std::string& title, const Curves& curves, const Scene& scene,
          const std::filesystem::path& file) {
  report::SingularValuePlot picture;
  picture.title = title;
  picture.frequencies_hz.assign(curves.frequencies_hz.begin(), curves.frequencies_hz.end());
  picture.open_predicted = curves.open;
  picture.closed_predicted = curves.closed;
  picture.closed_continuous = curves.continuous;
  if (scene.controller) {
    picture.target_frequency_hz = scene.controller->lowest_target_hz();
    picture.target_damping = scene.controller->damping_ratio.front();
  } else {
    // Units of all kinds: 120 dB below the highest point, and the values that are zero there too.
    const double highest = curves.open.array().isFinite().select(curves.open, 0.0).maxCoeff();
    picture.quantity = "inputs to outputs";
    picture.lowest_db = 20 * std::floor(std::log10(std::max(highest, 1e-300))) - 120;
    picture.open_predicted = curves.open.cwiseMax(std::pow(10.0, picture.lowest_db / 20));
  }
  report::plot_singular_values(picture, file);
}

/// The range asked for, or else what the model, its targets and its rate call for.
FrequencyRange range_of(const Options& options, FrequencyRange range) {
  range = {options.from_hz.value_or(range.lowest_hz), options.to_hz.value_or(range.highest_hz)};
  // One end that is given beyond the other that is not moves it along.
  if (!options.from_hz) range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  if (!options.to_hz) range.highest_hz = std::max(range.highest_hz, range.lowest_hz * 10);
  if (!(range.lowest_hz < range.highest_hz)) {
    throw InputError("--from: found " + report::cell("%g", range.lowest_hz) +
                     ", allowed is below --to");
  }
  return range;
}

int run(const Options& options) {
  require_own_places({{"the scene", options.scene}, {"the controller block", options.controller}},
                     {{"--plot", options.plot}});
  Patience patience("linearising");
  const Scene scene = read_scene(options.scene, options.controller);
  std::optional<LoopDesign> design;
  StateSpace system;
  if (scene.controller) {
    design = make_loop_design(options.scene, options.controller);
  } else {
    system = open_system(scene);
  }
  const FrequencyRange range =
      range_of(options, design ? axis_of(*design, scene.controller->target_hz)
                               : frequency_range(own_frequencies_hz(system.A), {}, 0));
  const auto curves_of = [&](int points) {
    patience.now("singular values");
    const Eigen::VectorXd frequencies =
        logarithmic_frequencies(range.lowest_hz, range.highest_hz, points);
    return design ? with_controller(*design, frequencies)
                  : without_controller(system, frequencies, patience);
  };
  if (design) {
    const std::string left_out = left_out_of_analysis(design->scene.instruments);
    if (!left_out.empty()) std::cerr << "stillframe: note: " << left_out << "\n";
  }
  if (design && range.highest_hz > design->gains.sample_rate_hz / 2) {
    std::cerr << "stillframe: note: above half the sample rate the loop that runs has no curve\n";
  }
  // A picture shows a resonance only as high as its grid is fine.
  if (options.plot)
    plot(scene.title, curves_of(std::max(options.points, 1000)), scene, *options.plot);
  const Curves curves = curves_of(options.points);
  if (options.json) {
    print_json(scene.title, curves);
  } else {
    print_table(scene.title, curves, design ? design->gains.sample_rate_hz : 0);
  }
  return exit_done;
}

}  // namespace

void add_sigma(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("sigma",
                                      "Singular values over frequency from the scene's inputs to "
                                      "its outputs, open and closed loop");
  verb->add_option("scene", options->scene, "Scene file (YAML)")->required()->type_name("SCENE");
  verb->add_option("--controller", options->controller,
                   "Controller block that replaces the scene's")
      ->type_name("FILE");
  verb->add_option("--from", options->from_hz,
                   "Lowest frequency, Hz; default: a tenth of the slowest mode or target")
      ->check(positive_number());
  verb->add_option("--to", options->to_hz,
                   "Highest frequency, Hz; default: four times the highest of the twelve slowest "
                   "modes and\nthe targets, at most half the sample rate")
      ->check(positive_number());
  verb->add_option("--points", options->points, "Frequencies, evenly spaced on a logarithmic axis")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  verb->add_option("--plot", options->plot, "Draw the curves into a PNG file")->type_name("FILE");
  verb->add_flag("--json", options->json, "Print JSON (keys below)");
  verb->footer(
      "Without a controller: outputs from inputs, each in the units the scene gives them, about "
      "the\n"
      "scene's operating point. With one: floor accelerations to output accelerations.\n"
      "Keys of --json:\n"
      "  scene, frequencies_hz\n"
      "  singular_values              open loop, a row a frequency, largest first; null at a pole\n"
      "  closed_singular_values       with a controller: the loop that runs, as it is sampled;\n"
      "                               null above half its rate\n"
      "  continuous_singular_values   with a controller: its law without sampling, delay and\n"
      "                               instruments\n"
      "Example: stillframe sigma config/scenes/cart.yaml --from 0.5 --to 20 --points 9");
  verb->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

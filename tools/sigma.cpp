#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/loop_design.hpp"
#include "judge/loop_peaks.hpp"
#include "report/plots/plots.hpp"
#include "report/table.hpp"
#include "tools/design_warnings.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/open_response.hpp"
#include "tools/patience.hpp"
#include "tools/reduction_text.hpp"
#include "tools/stability_note.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct SigmaOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, plot;
  std::optional<double> from_hz, to_hz;
  int points = 50;
  bool json = false;
};

/// A row a frequency. With a controller, closed is the loop that runs and open the frame left
/// alone, sampled as it is, both NaN above half its rate, and continuous its law without sampling,
/// delay and instruments. difference_at_most is of the open one of a scene with `reduce`.
struct Curves {
  Eigen::VectorXd frequencies_hz;
  Eigen::MatrixXd open, closed, continuous;
  Eigen::VectorXd difference_at_most;
};

Eigen::MatrixXd rows_of(const Eigen::VectorXd& frequencies_hz,
                        const std::function<Eigen::MatrixXcd(double omega)>& response) {
  Eigen::MatrixXd rows;
  for (Index i = 0; i < frequencies_hz.size(); ++i) {
    const Eigen::VectorXd values = singular_values(response(two_pi * frequencies_hz(i)));
    if (i == 0) rows.resize(frequencies_hz.size(), values.size());
    rows.row(i) = values.transpose();
  }
  return rows;
}

Curves without_controller(OpenResponse& open, const Eigen::VectorXd& frequencies_hz) {
  return {frequencies_hz,
          open.singular_values(frequencies_hz),
          {},
          {},
          open.difference_at_most(frequencies_hz)};
}

Curves with_controller(const judge::LoopDesign& design, const ReducedModel* reduced,
                       const Eigen::VectorXd& frequencies_hz) {
  Curves curves{
      frequencies_hz,
      rows_of(frequencies_hz, [&](double omega) { return transfer(design.open, omega); }),
      rows_of(frequencies_hz, [&](double omega) { return transfer(design.closed, omega); }),
      rows_of(frequencies_hz,
              [&](double omega) {
                return design.loop.closed({0.0, omega});
              }),
      reduced ? bounds_of(*reduced, frequencies_hz) : Eigen::VectorXd()};
  for (Index i = 0; i < frequencies_hz.size(); ++i) {
    // Half the rate itself is one of them, but for the rounding of its logarithm.
    if (frequencies_hz(i) <= (1 + 1e-9) * design.gains.sample_rate_hz / 2) continue;
    curves.open.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    curves.closed.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return curves;
}

void print_table(const std::string& title, const Curves& curves,
                 const std::vector<judge::PeakRow>& peaks, double sample_rate_hz) {
  const bool loop = curves.closed.size() > 0;
  std::cout << title << ": singular values, largest first"
            << (loop ? formatted("; of the loop that runs, sampled at %g Hz", sample_rate_hz) : "")
            << "\n";
  std::vector<std::string> header{"Hz"};
  for (const char* kind : {"open", "closed"}) {
    if (!loop && kind == std::string("closed")) continue;
    for (Index i = 0; i < curves.open.cols(); ++i)
      header.push_back(formatted("%s %td", kind, i + 1));
  }
  const bool reduced = curves.difference_at_most.size() > 0;
  if (reduced) header.push_back(loop ? "open off by at most" : "off by at most");
  if (!peaks.empty()) header.push_back("peak of");
  report::Table table(header, 0);
  for (Index f = 0; f < curves.frequencies_hz.size(); ++f) {
    const double hz = curves.frequencies_hz(f);
    const auto peak = std::find_if(peaks.begin(), peaks.end(),
                                   [hz](const judge::PeakRow& row) { return row.peak.hz == hz; });
    // At its own pole an undamped response has no values.
    const bool undamped = peak != peaks.end() && std::isinf(peak->peak.value);
    std::vector<std::string> row{formatted("%.4g", hz)};
    for (const auto* values : {&curves.open, &curves.closed}) {
      if (values->size() == 0) continue;
      const bool closed = values == &curves.closed;
      const bool unbounded = undamped && closed == (peak->of == judge::PeakRow::Of::closed);
      for (Index i = 0; i < values->cols(); ++i) {
        const double value = (*values)(f, i);
        if (unbounded) {
          row.push_back(i == 0 ? "no bound" : "-");
        } else {
          row.push_back(std::isnan(value) ? "-" : formatted("%.4e", value));
        }
      }
    }
    if (reduced) {
      const double at_most = curves.difference_at_most(f);
      row.push_back(std::isfinite(at_most) ? formatted("%.1e", at_most) : "-");
    }
    if (!peaks.empty()) {
      row.push_back(peak == peaks.end() ? "" : judge::name_of(peak->of) + std::string(" 1"));
    }
    table.add(row);
  }
  std::cout << table.print();
  if (reduced) {
    std::cout << "Off by at most: the largest singular value of the difference from the whole "
                 "model"
              << (loop ? ", without sampling" : "")
              << "; -: no bound, from the first mode that is left out, or where what is left "
                 "out is damped too strongly\n";
  }
}

Eigen::VectorXd with_peaks(const Eigen::VectorXd& frequencies_hz,
                           const std::vector<judge::PeakRow>& peaks) {
  std::vector<double> all(frequencies_hz.begin(), frequencies_hz.end());
  for (const judge::PeakRow& row : peaks) all.push_back(row.peak.hz);
  std::sort(all.begin(), all.end());
  return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Index>(all.size()));
}

void print_json(const std::string& title, const Json& stable, const Curves& curves,
                const std::vector<judge::PeakRow>& peaks) {
  Json document{{"scene", title},
                {"stable", stable},
                {"frequencies_hz", to_json(curves.frequencies_hz)},
                {"singular_values", to_json(curves.open)}};
  const bool closed = curves.closed.size() > 0;
  document["closed_singular_values"] = closed ? to_json(curves.closed) : Json();
  document["continuous_singular_values"] = closed ? to_json(curves.continuous) : Json();
  const bool reduced = curves.difference_at_most.size() > 0;
  document["difference_at_most"] = reduced ? to_json(curves.difference_at_most) : Json();
  document["peaks"] = Json::array();
  for (const judge::PeakRow& row : peaks) {
    document["peaks"].push_back(
        {{"of", judge::name_of(row.of)}, {"hz", row.peak.hz}, {"singular_value", row.peak.value}});
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
FrequencyRange range_of(const SigmaOptions& options, FrequencyRange range) {
  range = {options.from_hz.value_or(range.lowest_hz), options.to_hz.value_or(range.highest_hz)};
  // One end that is given beyond the other that is not moves it along.
  if (!options.from_hz) range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  if (!options.to_hz) range.highest_hz = std::max(range.highest_hz, range.lowest_hz * 10);
  if (!(range.lowest_hz < range.highest_hz)) {
    throw InputError("--from: found " + formatted("%g", range.lowest_hz) +
                     ", allowed is below --to");
  }
  return range;
}

int run(const SigmaOptions& options) {
  require_own_places({{"the scene", options.scene}, {"the controller block", options.controller}},
                     {{"--plot", options.plot}});
  Patience patience("linearising");
  const Scene scene = read_scene(options.scene, options.controller);
  hint_at_units(scene);
  std::optional<judge::LoopDesign> design;
  std::optional<OpenResponse> open;
  std::optional<ReducedModel> reduced;
  if (scene.controller) {
    design = judge::make_loop_design(options.scene, options.controller);
    if (scene.reduction) reduced = stable_reduced_loop(scene);
  } else {
    open.emplace(scene, patience);
  }
  const Json stable =
      design ? warn_unless_stable(design->model, design->loop.plant) : open->stable();
  const FrequencyRange range = range_of(
      options, design ? judge::axis_of(*design, scene.controller->target_hz) : open->range());
  std::optional<judge::LoopGains> gains;
  if (design) {
    gains = judge::gains_of(*design);
  } else if (std::optional<LargestGain> peaks = open->peaks()) {
    gains = {std::move(*peaks), {}, {}};
  }
  const auto grid = [&](int points) {
    return logarithmic_frequencies(range.lowest_hz, range.highest_hz, points);
  };
  const auto curves_of = [&](const Eigen::VectorXd& frequencies) {
    patience.now("singular values");
    return design ? with_controller(*design, reduced ? &*reduced : nullptr, frequencies)
                  : without_controller(*open, frequencies);
  };
  if (open && open->is_large() && gains && range.highest_hz > open->peaks_to_hz()) {
    std::cerr << formatted(
        "stillframe: note: peaks between the rows are looked for up to %.4g Hz; of so large a "
        "scene not more modes are computed\n",
        open->peaks_to_hz());
  }
  if (design) {
    const std::string left_out = left_out_of_analysis(design->scene.instruments);
    if (!left_out.empty()) std::cerr << "stillframe: note: " << left_out << "\n";
  }
  if (design && !(design->radius < largest_stable_radius)) {
    std::cerr << formatted(
        "stillframe: warning: the loop that runs is not stable (spectral radius %.9g), and its "
        "closed "
        "curves are of nothing that lasts; `stillframe design` says what would mend it\n",
        design->radius);
  }
  if (design && range.highest_hz > design->gains.sample_rate_hz / 2) {
    std::cerr << "stillframe: note: above half the sample rate what is sampled has no curve\n";
  }
  if (options.plot) {
    const Eigen::VectorXd fine = grid(std::max(options.points, 1000));
    plot(scene.title, curves_of(gains ? judge::with_resonances_of(*gains, fine) : fine), scene,
         *options.plot);
  }
  const Eigen::VectorXd rows = grid(options.points);
  const double rate = design ? design->gains.sample_rate_hz : 0;
  std::vector<judge::PeakRow> peaks;
  if (gains) peaks = judge::peak_rows(rows, *gains, rate);
  if (open && open->is_large()) {
    // The corrections of the reduced model swing too, above its modes.
    std::erase_if(peaks,
                  [&](const judge::PeakRow& row) { return row.peak.hz >= open->peaks_to_hz(); });
    for (judge::PeakRow& row : peaks) {
      if (std::isinf(row.peak.value)) continue;
      row.peak.value = open->singular_values(Eigen::VectorXd::Constant(1, row.peak.hz))(0, 0);
    }
  }
  if (options.json) {
    print_json(scene.title, stable, curves_of(rows), peaks);
  } else {
    std::erase_if(
        peaks, [](const judge::PeakRow& row) { return row.of == judge::PeakRow::Of::continuous; });
    print_table(scene.title, curves_of(with_peaks(rows, peaks)), peaks, rate);
  }
  return exit_done;
}

}  // namespace

void add_sigma(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<SigmaOptions>();
  cli::Command verb = app.verb("sigma",
                               "Singular values over frequency from the scene's inputs to "
                               "its outputs, open and closed loop");
  verb.option("scene", options->scene, "Scene file (YAML)").required().type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--from", options->from_hz,
              "Lowest frequency, Hz; default: a tenth of the slowest mode or target")
      .check(cli::positive_number());
  verb.option("--to", options->to_hz,
              "Highest frequency, Hz; default: four times the highest of the twelve slowest "
              "modes and\nthe targets, at most half the sample rate")
      .check(cli::positive_number());
  verb.option("--points", options->points, "Frequencies, evenly spaced on a logarithmic axis")
      .check(cli::whole_number(2, 1000000))
      .show_default();
  verb.option("--plot", options->plot, "Draw the curves into a PNG file").type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "About an operating point that is not stable there is no steady response: a warning says "
      "so,\n"
      "exit code 0.\n"
      "Without a controller: outputs from inputs, each in the units the scene gives them, about "
      "the\n"
      "scene's operating point. With one: floor accelerations to output accelerations.\n"
      "Keys of --json:\n"
      "  scene, frequencies_hz\n"
      "  stable                       whether nothing grows about the operating point without\n"
      "                               control, as `modes` judges; null: not known\n"
      "  singular_values              open loop, a row a frequency, largest first; null at a "
      "pole;\n"
      "                               with a controller: sampled as the loop that runs is, null\n"
      "                               above half its rate\n"
      "  closed_singular_values       with a controller: the loop that runs, likewise\n"
      "  continuous_singular_values   with a controller: its law without sampling, delay and\n"
      "                               instruments\n"
      "  difference_at_most           of a scene with `reduce`: a number a frequency, above the\n"
      "                               largest singular value of the difference of the open loop,\n"
      "                               without sampling, from the whole model; null: no bound, "
      "from\n"
      "                               the first mode that is left out, or where what is left out "
      "is\n"
      "                               damped too strongly\n"
      "  peaks                        of, hz, singular_value: between two of frequencies_hz the\n"
      "                               highest point of the open, closed or continuous curve,\n"
      "                               where it is more than 1 dB above both; the table has rows "
      "for\n"
      "                               those of its columns. null: no bound, as nothing damps it\n"
      "Example: stillframe sigma config/scenes/cart.yaml --from 0.5 --to 20 --points 9");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

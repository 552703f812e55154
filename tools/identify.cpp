#include <cmath>
#include <iostream>
#include <memory>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "judge/loop_comparison.hpp"
#include "report/export/mat_file.hpp"
#include "report/identification/confidence.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

struct IdentifyOptions {
  std::filesystem::path log;
  std::optional<std::int64_t> run_id;
  std::optional<int> plant;
  double segment_s = 64, level = 0.95;
  std::optional<double> tolerance_db;
  bool json = false;
};

struct Shown {
  const char* key;  ///< in the JSON
  const char* title;
  const judge::JudgedResponse* response;
};

std::vector<Shown> shown(const judge::RunAnalysis& run) {
  std::vector<Shown> list;
  if (run.matrix) list.push_back({"matrix", "Floor inputs to outputs", &*run.matrix});
  if (run.axes) list.push_back({"axes", "Floor to frame, axis by axis", &*run.axes});
  return list;
}

Json json_of(const std::vector<MatrixXcd>& matrices) {
  Json list = Json::array();
  for (const MatrixXcd& matrix : matrices) {
    Json rows = Json::array();
    for (Index i = 0; i < matrix.rows(); ++i) {
      rows.push_back(to_json(Eigen::VectorXcd(matrix.row(i).transpose())));
    }
    list.push_back(rows);
  }
  return list;
}

report::Bands bands_of(const judge::JudgedResponse& judged, double level) {
  return level == 0.95 ? judged.bands
                       : report::singular_value_bands(*judged.measured.response, level);
}

Json json_of(const report::PredictionError& error) {
  const auto of_any = [&](double value) { return error.n_compared > 0 ? Json(value) : Json(); };
  return {{"n_compared", error.n_compared},
          {"n_left_out", error.n_left_out},
          {"largest_db", of_any(error.largest_db)},
          {"at_hz", of_any(error.at_frequency_hz)},
          {"beyond_db", of_any(error.beyond_db)},
          {"beyond_at_hz", of_any(error.beyond_at_hz)},
          {"tolerance_db", error.tolerance_db},
          {"agrees", error.n_compared > 0 ? Json(error.agrees()) : Json(nullptr)}};
}

Json json_of(const judge::JudgedResponse& judged, double level) {
  const report::IdentifiedResponse& measured = judged.measured;
  Json json{{"inputs", measured.signals.inputs},
            {"outputs", measured.signals.outputs},
            {"method", measured.method},
            {"missing", measured.missing},
            {"unpredicted", judged.unpredicted},
            {"n_segments", measured.n_segments},
            {"n_filled", measured.n_filled},
            {"n_left_out", measured.n_left_out},
            {"resolution_hz", measured.resolution_hz}};
  for (const char* key :
       {"frequencies_hz", "T", "T_radius", "singular_values", "singular_values_lower",
        "singular_values_upper", "coherence", "directional_coherence", "dof", "input_condition",
        "noise_density", "T_sampled", "T_continuous", "sampled_singular_values",
        "continuous_singular_values", "sampled_error_db", "continuous_error_db", "comparison"}) {
    json[key] = Json();
  }
  if (!measured.response) return json;
  const report::FrequencyResponse& response = *measured.response;
  const report::Bands bands = bands_of(judged, level);
  Json radii = Json::array();
  for (Index l = 0; l < response.n_frequencies(); ++l) {
    radii.push_back(to_json(report::entry_radii(response, l, level)));
  }
  json["frequencies_hz"] = response.frequencies_hz;
  json["T"] = json_of(response.T);
  json["T_radius"] = radii;
  json["singular_values"] = to_json(response.singular_values);
  json["singular_values_lower"] = to_json(bands.lower);
  json["singular_values_upper"] = to_json(bands.upper);
  json["coherence"] = to_json(response.coherence);
  json["directional_coherence"] = to_json(response.directional_coherence);
  json["dof"] = to_json(response.dof);
  json["input_condition"] = to_json(response.input_condition);
  json["noise_density"] = to_json(response.noise_density);
  if (const auto& errors = judged.errors) {
    json["T_sampled"] = json_of(judged.predicted->sampled);
    json["T_continuous"] = json_of(judged.predicted->continuous);
    json["sampled_singular_values"] = to_json(errors->sampled_values);
    json["continuous_singular_values"] = to_json(errors->continuous_values);
    json["sampled_error_db"] = to_json(errors->sampled.difference_db);
    json["continuous_error_db"] = to_json(errors->continuous.difference_db);
    json["comparison"] = json_of(errors->sampled);
  }
  return json;
}

/// The largest magnitude of a row, NaN left out; a dash if there is none.
std::string largest_in(const MatrixXd& values, Index row) {
  double found = -1;
  for (Index i = 0; i < values.cols(); ++i) found = std::max(found, std::abs(values(row, i)));
  return found >= 0 ? formatted("%.4f", found) : "-";
}

/// Why rows of the table have no values.
void print_reasons(const report::FrequencyResponse& response) {
  Index still = 0, together = 0;
  for (Index l = 0; l < response.n_frequencies(); ++l) {
    if (!std::isnan(response.singular_values(l, 0))) continue;
    ++(std::isinf(response.input_condition(l)) ? still : together);
  }
  if (still > 0) {
    std::cout << formatted(
        "-, at %td frequencies: the floor moves too little there, or the record is too short for "
        "bins so narrow\n",
        still);
  }
  if (together > 0) {
    std::cout << formatted("-, at %td frequencies: the inputs do not move independently there\n",
                           together);
  }
}

void print_table(const Shown& item, double level) {
  const report::IdentifiedResponse& measured = item.response->measured;
  std::cout << item.title << ": "
            << formatted("%zu x %zu, %s", measured.signals.outputs.size(),
                         measured.signals.inputs.size(), measured.method.c_str());
  if (!measured.response) {
    std::cout << ": not identified: " << measured.missing << "\n\n";
    return;
  }
  std::cout << formatted(", resolution %.3g Hz, %lld %s", measured.resolution_hz,
                         static_cast<long long>(measured.n_segments),
                         measured.method == "multisine" ? "steady part" : "segment")
            << (measured.n_segments == 1 ? "" : "s");
  if (measured.n_filled > 0) {
    std::cout << formatted(", %lld lost samples filled in",
                           static_cast<long long>(measured.n_filled));
  }
  std::cout << "\n";
  const report::FrequencyResponse& response = *measured.response;
  const report::Bands bands = bands_of(*item.response, level);
  const auto& errors = item.response->errors;
  report::Table table({"Hz", "largest", "lower", "upper", "smallest", "lower", "upper",
                       "least coherence", "sampled dB", "continuous dB"},
                      0);
  const Index last = response.singular_values.cols() - 1;
  for (Index l = 0; l < response.n_frequencies(); ++l) {
    const auto value = [&](const MatrixXd& values, Index i) {
      return std::isnan(values(l, i)) ? "-" : formatted("%.4e", values(l, i));
    };
    const double coherence = response.directional_coherence.row(l).minCoeff();
    table.add({formatted("%.4g", response.frequencies_hz[static_cast<std::size_t>(l)]),
               value(response.singular_values, 0), value(bands.lower, 0), value(bands.upper, 0),
               value(response.singular_values, last), value(bands.lower, last),
               value(bands.upper, last), std::isnan(coherence) ? "-" : formatted("%.5f", coherence),
               errors ? largest_in(errors->sampled.difference_db, l) : "-",
               errors ? largest_in(errors->continuous.difference_db, l) : "-"});
  }
  std::cout << table.print();
  print_reasons(response);
  if (errors && errors->sampled.n_compared == 0) {
    std::cout << "Nothing is known well enough to be compared: no band of a singular value is "
                 "within 1 dB\n\n";
  } else if (errors) {
    const report::PredictionError& sampled = errors->sampled;
    std::cout << formatted(
        "%td of %td singular values are known well enough to be compared, to 1 dB. Largest error "
        "%.4f dB of the sampled prediction at %.4g Hz, %.4f dB beyond its band%s; %.4f dB of the "
        "continuous one at %.4g Hz\n\n",
        sampled.n_compared, sampled.n_compared + sampled.n_left_out, sampled.largest_db,
        sampled.at_frequency_hz, sampled.beyond_db,
        sampled.beyond_db > 0 ? formatted(" (at %.4g Hz)", sampled.beyond_at_hz).c_str() : "",
        errors->continuous.largest_db, errors->continuous.at_frequency_hz);
  } else {
    std::cout << "No prediction: " << item.response->unpredicted << "\n\n";
  }
}

int run(const IdentifyOptions& options) {
  Patience patience("reading");
  report::ComparisonRule rule;
  if (options.tolerance_db) rule.tolerance_db = *options.tolerance_db;
  const judge::RunAnalysis analysis = judge::analyse_run(
      options.log, {.run_id = options.run_id,
                    .plant = options.plant,
                    .segment_s = options.segment_s,
                    .comparison = rule,
                    .progress = [&](double share) { patience.now("reading", 100 * share); }});
  patience.now("confidence bands");
  const auto list = shown(analysis);
  if (list.empty()) {
    throw InputError(options.log.string() + ": nothing to identify: " +
                     (analysis.run.unreadable.empty()
                          ? "it does not say how the floor was moved, as that of a rig"
                          : analysis.run.unreadable));
  }
  bool identified = false, compared = false, agrees = true;
  Json document{{"scene", analysis.data.scan.info.scene_name},
                {"loop", analysis.data.scan.info.loop},
                {"sample_rate_hz", analysis.data.scan.info.sample_rate_hz},
                {"n_samples", analysis.data.scan.measurements.n_received},
                {"n_judged", analysis.data.n_judged},
                {"n_lost", analysis.data.scan.measurements.n_lost},
                {"level", options.level},
                {"warnings", Json::array()}};
  const std::string plants = plants_in_words(analysis.data.scan);
  if (!plants.empty()) document["warnings"].push_back(plants);
  if (!options.json) {
    std::cout << analysis.data.scan.info.scene_name << ", " << analysis.data.scan.info.loop
              << " loop: singular values with " << formatted("%g", 100 * options.level)
              << " % bands\n";
    if (!plants.empty()) std::cout << "Warning: " << plants << "\n";
    std::cout << "\n";
  }
  for (const Shown& item : list) {
    identified = identified || item.response->measured.response.has_value();
    if (const auto& errors = item.response->errors) {
      compared = true;
      agrees = agrees && errors->sampled.agrees();
    }
    if (options.json) {
      document[item.key] = json_of(*item.response, options.level);
    } else {
      print_table(item, options.level);
    }
  }
  if (options.json) print(document);
  return identified && (!options.tolerance_db || (compared && agrees)) ? exit_done : exit_failed;
}

}  // namespace

void add_identify(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<IdentifyOptions>();
  cli::Command verb = app.verb(
      "identify", "Frequency responses from a log, with confidence bands, against the predictions");
  verb.option("log", options->log, "LCM log of one run").required().type_name("LOG");
  verb.option("--run-id", options->run_id, "The run to take from a log that holds several");
  verb.option("--plant", options->plant,
              "The plant to take, from 1, of a run that several measured, as one does that "
              "was killed and came back (default: the last)");
  verb.option("--segment", options->segment_s,
              "Broadband identification: s of what is transformed at once; longer is finer")
      .check(cli::positive_number())
      .show_default();
  verb.option("--level", options->level, "Probability with which the bands hold the truth")
      .check(cli::number_between(0.5, 0.999))
      .show_default();
  verb.option("--tolerance-db", options->tolerance_db,
              "Fail if a prediction lies further than this outside the band of its value")
      .check(cli::number_from_zero());
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "On a multisine floor by its lines (docs/identification.md), on any other by the local\n"
      "polynomial method: the matrix from all floor inputs to the scene's outputs if the floor\n"
      "moves them independently, and the matrix of the scene's comparisons, floor to frame.\n"
      "Errors in dB are the largest of the singular values whose 95 % bands are within 1 dB.\n"
      "Keys of --json:\n"
      "  scene, loop, sample_rate_hz, n_samples, n_judged (those while a loop by the clock held "
      "the\n"
      "  frame), n_lost, level\n"
      "  warnings: that several plants measured the run\n"
      "  matrix, axes: inputs, outputs, method, missing, unpredicted, n_segments, n_filled,\n"
      "    n_left_out, resolution_hz, and if identified\n"
      "    frequencies_hz, T (pairs re, im), T_radius, singular_values, singular_values_lower,\n"
      "    singular_values_upper, coherence (an output), directional_coherence (a singular\n"
      "    value), dof, input_condition, noise_density (output unit^2 / Hz), and if predicted\n"
      "    T_sampled, T_continuous, sampled_singular_values, continuous_singular_values,\n"
      "    sampled_error_db, continuous_error_db (null: not compared), comparison (with the "
      "sampled\n"
      "    prediction: n_compared, n_left_out, largest_db, at_hz, beyond_db, outside all bands\n"
      "    together at 95 %, beyond_at_hz, tolerance_db, agrees)\n"
      "Exit code 4: nothing could be identified, or with --tolerance-db nothing could be compared "
      "or\n"
      "something lies beyond it.\n"
      "Example: stillframe identify runs/identification/active.lcm");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include "tools/commission_text.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>

#include "core/errors/formatted.hpp"
#include "core/files/bytes_of_file.hpp"
#include "core/numerics/worst.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::VectorXd;
using judge::alike;
using judge::Commissioned;
using judge::found_deviation;
using judge::found_doubt;
using judge::is_told;
using judge::known_before;

namespace {

constexpr double clear_of_rest_db = 6;

Json parameters_json(const Commissioned& found) {
  Json parameters = Json::array();
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    const auto& parameter = found.question.parameters[i];
    Json with = Json::array();
    for (const std::size_t other : alike(found, i)) {
      with.push_back(name_of(found.question.parameters[other]));
    }
    parameters.push_back({{"name", name_of(parameter)},
                          {"deviation", found_deviation(found, i)},
                          {"standard_deviation", found_doubt(found, i)},
                          {"known_before", known_before(found, i)},
                          {"told", is_told(found, i)},
                          {"alike", with}});
  }
  return parameters;
}

Json outputs_json(const Commissioning& all) {
  Json outputs = Json::array();
  const auto m = static_cast<Index>(all.legs.size());
  const auto& fit = all.found->fit;
  for (Index i = 0; i < fit.left.size(); ++i) {
    const std::string name =
        i < 2 * m ? (i < m ? "sigma " : "applied ") + all.legs[static_cast<std::size_t>(i % m)]
                  : all.rig.frame[static_cast<std::size_t>(i - 2 * m)];
    outputs.push_back({{"name", name}, {"left_before", fit.left_before(i)}, {"left", fit.left(i)}});
  }
  return outputs;
}

/// What a response is of: in JSON, in a sentence, in a figure.
struct Words {
  const char *key, *sentence, *figure;
};

Words words_of(judge::ClosedResponse::Of of) {
  using Of = judge::ClosedResponse::Of;
  switch (of) {
    case Of::frame:
      return {"frame", "accelerations of the frame", "frame accelerations (m/s\u00b2 per N)"};
    case Of::sigma:
      return {"sigma", "readings of the force sensors", "force sensors (N per N)"};
    case Of::strain:
      break;
  }
  return {"strain", "forces of the legs' stiffness", "forces of the legs' stiffness (N per N)"};
}

Json closed_json(const Commissioning& all) {
  const ClosedOnRig& closed = *all.closed;
  const bool is_compared = all.has_both_peaks();
  const Json driven_peak = is_compared ? to_json(judge::frame_peak(*all.found)) : Json();
  Json responses = Json::array();
  for (const judge::ClosedResponse& response : closed.responses) {
    const Index worst = response.worst();
    const bool has_mean = std::isfinite(response.mean_doubt_db());
    responses.push_back({{"of", words_of(response.of).key},
                         {"frequencies_hz", to_json(response.frequencies_hz)},
                         {"measured", to_json(response.measured)},
                         {"standard_deviation", to_json(response.noise)},
                         {"predicted", to_json(response.predicted)},
                         {"passive", to_json(response.passive)},
                         {"n_told", response.n_told()},
                         {"n_acting", response.n_acting()},
                         {"mean_db", has_mean ? Json(response.mean_off_db()) : Json()},
                         {"mean_doubt_db", has_mean ? Json(response.mean_doubt_db()) : Json()},
                         {"worst_db", worst < 0 ? Json() : Json(response.off_db(worst))},
                         {"worst_hz", worst < 0 ? Json() : Json(response.frequencies_hz(worst))},
                         {"as_predicted", response.is_as_predicted()}});
  }
  const controller::ClosedRecording& run = closed.run;
  return {{"responses", responses},
          {"frame_peak_m_s2", to_json(run.frame_peak)},
          {"force_peak_n", run.force_peak},
          {"added_force_n", run.added_force},
          {"n_lost", run.recording.n_lost},
          {"n_saturated", run.n_saturated},
          {"n_faults", run.n_faults},
          {"frame_peak_driven_m_s2", driven_peak},
          {"shaken_harder", is_compared ? Json(all.is_shaken_harder()) : Json()},
          {"as_predicted", are_as_predicted(closed.responses)}};
}

std::string with_unit(const robustness::Parameter& parameter, double deviation) {
  return deviation_text(parameter, deviation / parameter.size);
}

/// Rows of name, note, found, doubt and known before.
std::vector<std::vector<std::string>> parameter_rows(const Commissioned& found) {
  const auto& parameters = found.question.parameters;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto others = alike(found, i);
    std::string note;
    if (others.size() == 1) note = "or " + name_of(parameters[others[0]]);
    if (others.size() > 1) note = formatted("or with %zu others", others.size());
    if (!is_told(found, i)) note = "not told" + (note.empty() ? "" : ", " + note);
    const auto without_sign = [&](double deviation) {
      return with_unit(parameters[i], deviation).substr(1);
    };
    rows.push_back(
        {name_of(parameters[i]), note, with_unit(parameters[i], found_deviation(found, i)),
         without_sign(1.96 * found_doubt(found, i)), without_sign(known_before(found, i))});
  }
  return rows;
}

std::vector<std::string> parameter_columns() {
  return {"what", "", "found", "+- (95 %)", "known before"};
}

std::string recorded_line(const Commissioned& found) {
  const std::string late =
      found.n_late > 0 ? ", " + std::to_string(found.n_late) + " commands a sample late" : "";
  return formatted(
      "%lld samples, %lld lost%s, clock %+.1f ppm; driven by %.3g N, the least output reads %.0f "
      "dB more than at rest",
      report::count(found.recording.n_samples), report::count(found.recording.n_lost), late.c_str(),
      -1e6 * found.recording.drift, found.force_n, found.disturbance_db);
}

/// What to think of the fit, a sentence each.
std::vector<std::string> fit_lines(const Commissioning& all) {
  const Commissioned& found = *all.found;
  std::vector<std::string> lines;
  if (found.disturbance_db < clear_of_rest_db) {
    lines.push_back(formatted("That is little: with a larger --force, bands are narrower."));
  }
  lines.push_back(formatted("What is left is %.2f times the power of the noise at rest.",
                            found.fit.over_noise));
  if (found.fit.n_left_out > 0) {
    lines.push_back(
        formatted("%d windows were left out: something happened in each (a knock, say).",
                  found.fit.n_left_out));
  }
  if (!found.fit.is_noise()) {
    lines.push_back(
        "The rig does something that no value of these parameters does: do not trust the bands.");
  }
  if (!anything_told(found)) lines.push_back("The rig tells nothing of what was asked.");
  if (!found.fit.converged) lines.push_back("The fit has not settled.");
  lines.push_back(formatted(
      "Spectral radius on what was found: %.6f with the gains of before, %.6f with those of the "
      "updated scene.",
      all.loops->before, all.loops->after));
  return lines;
}

std::vector<std::string> closed_lines(const Commissioning& all) {
  const ClosedOnRig& closed = *all.closed;
  std::vector<std::string> lines;
  for (const judge::ClosedResponse& response : closed.responses) {
    const Index worst = response.worst();
    const std::string what = words_of(response.of).sentence;
    if (worst < 0) {
      lines.push_back("Closed: noise hides what added forces make of the " + what +
                      ". Take a larger --force, or more --windows.");
      continue;
    }
    std::string line = formatted(
        "Closed, from added forces to %s: told at %lld of %lld frequencies, furthest off its "
        "prediction at %.3g Hz, by %+.2f dB (noise: %.2f dB); ",
        what.c_str(), report::count(response.n_told()),
        report::count(response.frequencies_hz.size()), response.frequencies_hz(worst),
        response.off_db(worst), response.doubt_db(worst));
    const bool has_mean = std::isfinite(response.mean_doubt_db());
    line += has_mean ? formatted("all together %+.2f dB (noise: %.2f dB); ", response.mean_off_db(),
                                 response.mean_doubt_db())
                     : "all together hidden by noise; ";
    line += response.n_acting() > 0
                ? formatted("the law is seen to act at %lld.", report::count(response.n_acting()))
                : "the law is not seen to act: take a larger --force, or more --windows.";
    if (response.n_acting() > 0 && !has_mean) {
      line += " Take a larger --force, or more --windows.";
    } else if (response.n_acting() > 0 && !response.is_known()) {
      line +=
          formatted(" Noise leaves %.2f dB, %g may be: take a larger --force, or more --windows.",
                    response.mean_doubt_db(), judge::ClosedResponse::most_db);
    } else if (!response.is_as_predicted() && response.n_acting() > 0) {
      line += formatted(" That is more than %g dB: the rig is not as the updated scene says.",
                        judge::ClosedResponse::most_db);
    }
    lines.push_back(line);
  }
  std::string peaks = formatted("%.3g N were added at most; largest command %.3g N",
                                closed.run.added_force, closed.run.force_peak);
  if (closed.run.frame_peak.size() > 0) {
    peaks += formatted("; largest acceleration of the frame %.3g m/s^2",
                       closed.run.frame_peak.maxCoeff());
    if (all.has_both_peaks()) {
      peaks += formatted(", %.3g m/s^2 while it was driven without the loop",
                         judge::frame_peak(*all.found).maxCoeff());
    }
  }
  lines.push_back(peaks + ".");
  if (const auto axes = all.shaken_axes(); !axes.empty()) {
    std::string names;
    for (const std::size_t i : axes) names += (names.empty() ? "" : ", ") + all.rig.frame[i];
    lines.push_back(
        formatted("More than %g times as much as without the loop was read by %s: the "
                  "loop shakes the frame there.",
                  most_shaken_axis, names.c_str()));
  } else if (all.is_shaken_harder()) {
    lines.push_back(
        formatted("That is more than %g times as much: the loop shakes the frame.", most_shaken));
  }
  if (closed.run.n_faults > 0) {
    lines.push_back(formatted("Faults that passed: %lld (%s).", report::count(closed.run.n_faults),
                              closed.run.last_fault.c_str()));
  }
  if (closed.run.n_saturated > 0) {
    lines.push_back(
        formatted("Commands that met a limit: %lld.", report::count(closed.run.n_saturated)));
  }
  return lines;
}

std::vector<double> list(const VectorXd& values) { return {values.begin(), values.end()}; }

page::SingularValueFigure figure_of(const judge::ClosedResponse& response) {
  page::SingularValueFigure figure;
  figure.quantity = std::string("added forces to ") + words_of(response.of).figure;
  figure.of_floor = false;
  figure.frequencies_hz = list(response.axis_hz);
  figure.open = response.passive_axis;
  figure.closed = response.predicted_axis;
  page::MeasuredValues& measured = figure.closed_measured;
  // A band that reaches down to nothing begins where it can still be drawn.
  constexpr double least_part = 0.01;
  const Index n = response.measured.size();
  measured.frequencies_hz = list(response.frequencies_hz);
  measured.values = response.measured;
  measured.lower =
      (response.measured - 2 * response.noise).cwiseMax(least_part * response.measured);
  measured.upper = response.measured + 2 * response.noise;
  measured.difference_db.resize(n, 1);
  for (Index l = 0; l < n; ++l) {
    measured.difference_db(l, 0) =
        response.is_told(l) ? response.off_db(l) : std::numeric_limits<double>::quiet_NaN();
  }
  figure.allowed_db = judge::ClosedResponse::most_db;
  return figure;
}

/// Force sensor over actuator, leg by leg.
std::vector<page::TransmissibilityAxis> fit_figures(const Commissioning& all) {
  const judge::Commissioned& found = *all.found;
  const double window_s = static_cast<double>(found.n_window) * found.question.sampling.sample_time;
  std::vector<double> f;
  for (const int line : found.lines) f.push_back(line / window_s);
  std::vector<page::TransmissibilityAxis> figures;
  for (std::size_t i = 0; i < all.legs.size(); ++i) {
    const fitting::LegResponse& leg = found.fit.legs[i];
    page::TransmissibilityAxis figure{.axis = all.legs[i],
                                      .frequencies_hz = f,
                                      .passive = list(leg.before.cwiseAbs()),
                                      .active = list(leg.fitted.cwiseAbs()),
                                      .passive_measured = {},
                                      .active_measured = {}};
    figure.active_measured.frequencies_hz = f;
    figure.active_measured.values = leg.measured.cwiseAbs();
    figures.push_back(std::move(figure));
  }
  return figures;
}

page::Table table_of(const judge::ClosedResponse& response) {
  page::Table table{
      .caption = std::string("Closed, from added forces to ") + words_of(response.of).sentence,
      .columns = {"Hz", "measured", "\u00b1", "predicted", "without the law", "dB off"},
      .rows = {}};
  for (Index l = 0; l < response.measured.size(); ++l) {
    table.rows.push_back(
        {formatted("%.4g", response.frequencies_hz(l)), formatted("%.3g", response.measured(l)),
         formatted("%.2g", 2 * response.noise(l)), formatted("%.3g", response.predicted(l)),
         formatted("%.3g", response.passive(l)),
         response.is_told(l) ? formatted("%+.2f", response.off_db(l)) : "hidden"});
  }
  return table;
}

}  // namespace

bool Commissioning::has_both_peaks() const {
  return closed && closed->run.frame_peak.size() > 0 && found && !found->recording.windows.empty();
}

std::vector<std::size_t> Commissioning::shaken_axes() const {
  std::vector<std::size_t> axes;
  if (!has_both_peaks()) return axes;
  const VectorXd driven = judge::frame_peak(*found), &peak = closed->run.frame_peak;
  const double least = heard_part * worst_of(driven);
  for (Index i = 0; i < peak.size(); ++i) {
    if (peak(i) > most_shaken_axis * driven(i) && peak(i) > least) {
      axes.push_back(static_cast<std::size_t>(i));
    }
  }
  return axes;
}

bool Commissioning::is_shaken_harder() const {
  if (!has_both_peaks()) return false;
  const bool all_known_and_less =
      worst_of(closed->run.frame_peak) <= most_shaken * worst_of(judge::frame_peak(*found));
  return !all_known_and_less || !shaken_axes().empty();
}

bool Commissioning::is_closed_well() const {
  return closed && are_as_predicted(closed->responses) && !is_shaken_harder();
}

namespace {

void print_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::cout << line << "\n";
}

}  // namespace

Json to_json(const Commissioning& all) {
  Json wrong = Json::array();
  if (all.found) {
    for (const auto& leg : all.found->wiring.legs) {
      for (const std::string& what : leg.wrong) wrong.push_back({{"leg", leg.leg}, {"what", what}});
    }
  }
  const bool fitted = all.is_fitted();
  const auto path = [](const std::optional<std::filesystem::path>& file) {
    return file ? Json(file->string()) : Json();
  };
  return {{"scene", all.title},
          {"wrong", wrong},
          {"connected", all.found ? Json(all.found->wiring.connected) : Json()},
          {"clock_ppm", fitted ? Json(-1e6 * all.found->recording.drift) : Json()},
          {"n_samples", fitted ? Json(all.found->recording.n_samples) : Json()},
          {"n_lost", fitted ? Json(all.found->recording.n_lost) : Json()},
          {"parameters", fitted ? parameters_json(*all.found) : Json::array()},
          {"outputs", fitted ? outputs_json(all) : Json::array()},
          {"over_noise", fitted ? Json(all.found->fit.over_noise) : Json()},
          {"n_late", fitted ? Json(all.found->n_late) : Json()},
          {"n_left_out", fitted ? Json(all.found->fit.n_left_out) : Json()},
          {"converged", fitted ? Json(all.found->fit.converged) : Json()},
          {"spectral_radius_before", fitted ? Json(all.loops->before) : Json()},
          {"spectral_radius", fitted ? Json(all.loops->after) : Json()},
          {"scene_file", path(all.files.scene)},
          {"rig_file", path(all.files.rig)},
          {"uncertainty_file", path(all.files.uncertainty)},
          {"closed", all.closed ? closed_json(all) : Json()},
          {"passed", all.passed}};
}

void print_wiring(const Commissioning& all) {
  const controller::Wiring& wiring = all.found->wiring;
  for (const auto& leg : wiring.legs) {
    for (const std::string& what : leg.wrong) std::cout << leg.leg << ": " << what << "\n";
  }
  if (wiring.sound) std::cout << "Every leg answers as the rig file and the scene say.\n";
  if (!wiring.connected) {
    std::cout << "No rig file can put all of it right: nothing else was done.\n";
  } else if (!wiring.sound) {
    std::cout
        << "Cables and signs are put right for what follows, and gains that are off by more than "
           "half; the rest is for the fit.\n";
  }
}

void print_parameters(const Commissioning& all) {
  const Commissioned& found = *all.found;
  std::cout << "\n" << recorded_line(found) << "\n\n";
  report::Table table(parameter_columns(), 2);
  bool trade = false;
  const auto rows = parameter_rows(found);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    trade = trade || !alike(found, i).empty();
    table.add(rows[i]);
  }
  std::cout << table.print();
  if (trade) {
    std::cout
        << "or ...: this rig tells both together rather than each (--json has all names). All "
           "forces, masses\nand stiffnesses times one number are the same to force sensors "
           "and accelerometers.\n";
  }
  std::cout << "\n";
  print_lines(fit_lines(all));
  std::cout << "Written: " << all.files.scene->string() << ", " << all.files.uncertainty->string();
  if (all.files.rig) std::cout << ", " << all.files.rig->string();
  std::cout << "\n";
}

void print_closed(const Commissioning& all) {
  std::cout << "\n";
  print_lines(closed_lines(all));
}

page::PageData page_of(const Commissioning& all) {
  page::PageData data;
  data.head.title = all.title + (all.how.played.empty() ? ", commissioned" : ", a rehearsal");
  data.head.program_version = STILLFRAME_VERSION;
  data.head.scene_name = all.title;
  data.head.date = all.how.date;
  data.head.outcome = all.passed ? report::Outcome::passed : report::Outcome::failed;
  if (all.is_fitted()) {
    data.head.headlines = fit_lines(all);
    data.head.headlines.insert(data.head.headlines.begin(), recorded_line(*all.found) + ".");
    data.fit = fit_figures(all);
  }
  if (all.closed) {
    const auto lines = closed_lines(all);
    data.head.headlines.insert(data.head.headlines.end(), lines.begin(), lines.end());
    for (const judge::ClosedResponse& response : all.closed->responses) {
      data.checks.push_back(table_of(response));
    }
    data.singular_values = figure_of(all.closed->responses.front());
  }
  page::Table how{.caption = "How", .columns = {"what", ""}, .rows = {}};
  how.rows.push_back(all.how.played.empty()
                         ? std::vector<std::string>{"rig", all.rig.title + ", " + all.rig.driver}
                         : std::vector<std::string>{"rig", "none: played by " + all.how.played});
  how.rows.push_back({"scene", all.how.scene});
  how.rows.push_back({"force", formatted("%g N", all.how.force_n)});
  how.rows.push_back({"windows", formatted("%d of %g s", all.how.windows, all.how.window_s)});
  data.checks.push_back(how);
  if (all.found) {
    page::Table wiring{.caption = "Wiring, as it was", .columns = {"leg", "what"}, .rows = {}};
    for (const auto& leg : all.found->wiring.legs) {
      for (const std::string& what : leg.wrong) wiring.rows.push_back({leg.leg, what});
      if (leg.wrong.empty()) wiring.rows.push_back({leg.leg, "as the rig file and the scene say"});
    }
    data.checks.push_back(wiring);
  }
  if (all.is_fitted()) {
    data.checks.push_back({.caption = "Parameters, by how much they are off the scene",
                           .columns = parameter_columns(),
                           .rows = parameter_rows(*all.found)});
    data.texts.push_back({"Corrections", judge::corrections_block(*all.found)});
    data.texts.push_back({"What is left to doubt", judge::uncertainty_left(*all.found)});
    if (all.files.rig) {
      data.texts.push_back({"Rig file", bytes_of_file(*all.files.rig).value_or("")});
    }
  }
  return data;
}

}  // namespace stillframe::tools

#include "tools/budget_text.hpp"

#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/spectra/spectra.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

const char* words_of(judge::BudgetMethod method) {
  return method == judge::BudgetMethod::feed_forward ? "feed-forward" : judge::name_of(method);
}

std::string mm_s2(double rms) { return rms > 0 ? formatted("%.4g", 1e3 * rms) : "0"; }

std::string percent(double share, double total) {
  // Adding 0 takes the sign off what is rounded to nothing.
  return total > 0 ? formatted("%.2f", std::round(1e4 * share / total) / 100 + 0.0) : "-";
}

/// The largest of the third octaves, um/s and Hz.
std::string largest_band(const VectorXd& velocity) {
  Index at = -1;
  for (Index i = 0; i < velocity.size(); ++i) {
    if (std::isnan(velocity(i))) break;
    if (at < 0 || velocity(i) > velocity(at)) at = i;
  }
  if (at < 0) return "-";
  return formatted("%.4g at %g", 1e6 * velocity(at),
                   report::third_octave_bands()[static_cast<std::size_t>(at)].nominal_hz);
}

/// Below what half of the mean square is.
std::string middle_hz(const judge::Budget& budget, const judge::BudgetPart& total) {
  const double half = total.power.sum() / 2;
  double below = 0;
  for (Index i = 0; i < total.power.size(); ++i) {
    below += total.power(i);
    if (below >= half && half > 0) return formatted("%.3g", budget.edges_hz(i + 1));
  }
  return "-";
}

report::Table table_of(const judge::Budget& budget) {
  std::vector<std::string> header{"axis", "source", "floor"};
  for (const judge::MethodBudget& one : budget.methods) {
    header.push_back(words_of(one.method));
    header.push_back("share %");
  }
  report::Table table(header, 2);
  for (std::size_t i = 0; i < budget.axes.size(); ++i) {
    const std::string& axis = budget.axes[i].name;
    for (std::size_t s = 0; s < budget.sources.size(); ++s) {
      std::vector<std::string> row{axis, budget.sources[s], ""};
      for (const judge::MethodBudget& one : budget.methods) {
        const judge::SignalBudget& signal = one.axes[i];
        row.push_back(mm_s2(signal.sources[s].rms));
        row.push_back(percent(signal.sources[s].share, signal.total.share));
      }
      table.add(std::move(row));
    }
    const judge::SignalBudget& floor = budget.floors[i];
    const bool there = floor.total.power.size() > 0;
    const auto add = [&](const std::string& name, const auto& of) {
      std::vector<std::string> row{axis, name, there ? of(floor) : "-"};
      for (const judge::MethodBudget& one : budget.methods) {
        row.push_back(of(one.axes[i]));
        row.push_back("");
      }
      table.add(std::move(row));
    };
    add("all", [](const judge::SignalBudget& signal) { return mm_s2(signal.total.rms); });
    add("half below Hz",
        [&](const judge::SignalBudget& signal) { return middle_hz(budget, signal.total); });
    add("band um/s, Hz",
        [](const judge::SignalBudget& signal) { return largest_band(signal.total.velocity); });
    add("class", [](const judge::SignalBudget& signal) { return signal.vibration_class; });
  }
  return table;
}

report::Table table_of(const std::vector<judge::BudgetCheck>& checks, double within) {
  report::Table table({"axis", "method", "predicted mm/s^2", "+-", "measured", "difference %", ""},
                      2);
  for (const judge::BudgetCheck& check : checks) {
    table.add({check.axis, words_of(check.method), mm_s2(check.predicted), mm_s2(check.scatter),
               mm_s2(check.measured), formatted("%.2f", 100 * check.difference()),
               check.met(within) ? "" : "beyond"});
  }
  return table;
}

VectorXd cumulative_rms(const VectorXd& power) {
  VectorXd rms(power.size());
  double sum = 0;
  for (Index i = 0; i < power.size(); ++i) {
    // What is constant in a course may be a rounding below nothing.
    sum += power(i);
    rms(i) = std::sqrt(std::max(sum, 0.0));
  }
  return rms;
}

Json json_of(const judge::BudgetPart& part) {
  return {{"rms_m_s2", part.rms},
          {"share_m2_s4", part.share},
          {"cumulative_rms_m_s2", to_json(cumulative_rms(part.power))},
          {"shared_m2_s4", to_json(part.shared)},
          {"third_octaves_m_s", to_json(part.velocity)}};
}

Json json_of(const judge::SignalBudget& signal) {
  Json json = json_of(signal.total);
  json["scatter_m_s2"] = signal.scatter;
  json["vibration_class"] = signal.vibration_class;
  return json;
}

Json json_of(const judge::SignalBudget& signal, const std::vector<std::string>& sources) {
  Json json = json_of(signal);
  json["sources"] = Json::object();
  for (std::size_t i = 0; i < signal.sources.size(); ++i) {
    json["sources"][sources[i]] = json_of(signal.sources[i]);
  }
  return json;
}

}  // namespace

std::string budget_text(const std::string& title, const judge::Budget& budget,
                        const std::vector<judge::BudgetRun>& runs, double within) {
  const double seconds = static_cast<double>(budget.n_samples - 1) / budget.sample_rate_hz;
  std::string text =
      title +
      formatted(": error budget of %g s at %g Hz, from rest\n", seconds, budget.sample_rate_hz) +
      "mm/s^2 rms of each source by itself, and its share of the mean square of "
      "all\n" +
      table_of(budget).print();
  if (!budget.left_out.empty()) {
    text += "Not linear, and left out of the budget: " + budget.left_out + "\n";
  }
  const std::vector<judge::BudgetCheck> checks = judge::checks_of(budget, runs);
  if (!checks.empty()) {
    text += formatted("Held against runs, within %g %% and two of +-, the scatter of one run:\n",
                      100 * within) +
            table_of(checks, within).print();
  }
  return text;
}

Json budget_json(const std::string& title, const judge::Budget& budget,
                 const std::vector<judge::BudgetRun>& runs, double within) {
  Json json{{"scene", title},
            {"sample_rate_hz", budget.sample_rate_hz},
            {"n_samples", budget.n_samples},
            {"left_out", budget.left_out},
            {"edges_hz", to_json(budget.edges_hz)},
            {"bands_hz", Json::array()},
            {"sources", budget.sources},
            {"axes", Json::object()},
            {"runs", Json::array()}};
  for (const report::OctaveBand& band : report::third_octave_bands()) {
    json["bands_hz"].push_back(band.nominal_hz);
  }
  for (std::size_t i = 0; i < budget.axes.size(); ++i) {
    Json& axis = json["axes"][budget.axes[i].name];
    axis["frame"] = budget.axes[i].frame;
    const bool there = budget.floors[i].total.power.size() > 0;
    axis["floor"] = there ? json_of(budget.floors[i]) : Json(nullptr);
    for (const judge::MethodBudget& one : budget.methods) {
      axis["methods"][judge::name_of(one.method)] = json_of(one.axes[i], budget.sources);
    }
  }
  for (const judge::BudgetRun& run : runs) {
    Json of_run{{"log", run.log.string()}, {"method", judge::name_of(run.method)}};
    of_run["axes"] = Json::object();
    const std::vector<judge::BudgetCheck> checks = judge::checks_of(budget, {run});
    for (std::size_t i = 0; i < checks.size(); ++i) {
      of_run["axes"][checks[i].axis] = {{"predicted_m_s2", checks[i].predicted},
                                        {"scatter_m_s2", checks[i].scatter},
                                        {"measured_m_s2", checks[i].measured},
                                        {"met", checks[i].met(within)},
                                        {"third_octaves_m_s", to_json(run.axes[i].velocity)},
                                        {"vibration_class", run.axes[i].vibration_class}};
    }
    json["runs"].push_back(std::move(of_run));
  }
  return json;
}

}  // namespace stillframe::tools

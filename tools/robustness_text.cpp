#include "tools/robustness_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "core/errors/formatted.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

using report::Table;
using robustness::Case;
using robustness::Extremes;
using robustness::Histogram;
using robustness::Measure;
using robustness::Outcome;
using robustness::Parameter;
using robustness::Record;
using robustness::Tally;

namespace {

constexpr double table_frequencies_hz[] = {1, 2, 5, 10, 20, 50, 100};
constexpr double shares[] = {0.05, 0.50, 0.95, 0.99};
constexpr size_t n_worst_shown = 3;

std::string count_lines(const Record& record) {
  const Tally& tally = record.tally;
  std::string text =
      formatted("%zu parameters, seed %llu, %llu of %llu samples", record.parameters.size(),
                static_cast<unsigned long long>(record.seed),
                static_cast<unsigned long long>(tally.n_samples()),
                static_cast<unsigned long long>(record.samples));
  if (!record.complete()) {
    text += formatted(" (%zu of %llu shards)", record.shards.size(),
                      static_cast<unsigned long long>(record.n_shards));
  }
  text += formatted("\nStable %llu, unstable %llu, failed %llu\n",
                    static_cast<unsigned long long>(tally.n_stable),
                    static_cast<unsigned long long>(tally.n_unstable),
                    static_cast<unsigned long long>(tally.n_failed()));
  for (const auto& [why, count] : tally.failures) {
    text += formatted("  failed %llu times: ", static_cast<unsigned long long>(count)) + why + "\n";
  }
  if (tally.n_samples() > 0) {
    const BadShare share = bad_share(tally);
    text += formatted("Unstable or failed: %.4g %%, below %.4g %% with a confidence of 95 %%\n",
                      100 * share.found, 100 * share.below);
  }
  return text;
}

/// A row of the spread of one number: nominal, quantiles, worst.
template <class H>
void add_spread(Table& table, const std::string& name, double nominal, const H& histogram,
                const Extremes& extremes, double worst, double (*shown)(double),
                const char* format) {
  std::vector<std::string> row{name, formatted(format, nominal)};
  for (const double share : shares) {
    row.push_back(formatted(format, shown(quantile_within(histogram, extremes, share))));
  }
  row.push_back(formatted(format, worst));
  table.add(row);
}

/// log10 of the slowest decay, 1/s; the fastest loop has the smallest radius. Unbounded below where
/// one is unstable, as its radius says nothing of the stable ones.
Extremes decay_extremes(const Record& record) {
  const auto& radius = record.tally.radius;
  const auto decay = [&](double r) { return std::log10(-std::log(r) / record.sample_time); };
  return {.least = radius.most < 1 ? decay(radius.most) : -infinity, .most = decay(radius.least)};
}

std::string spread_table(const Record& record) {
  const Tally& tally = record.tally;
  const auto same = [](double value) { return value; };
  const auto power = [](double value) { return std::pow(10.0, value); };
  Table table({"", "nominal", "5 %", "50 %", "95 %", "99 %", "worst"}, 1);
  for (Eigen::Index i = 0; i < record.frequencies_hz.size(); ++i) {
    const double f = record.frequencies_hz(i);
    if (std::find(std::begin(table_frequencies_hz), std::end(table_frequencies_hz), f) ==
        std::end(table_frequencies_hz)) {
      continue;
    }
    const auto at = static_cast<size_t>(i);
    add_spread(table, formatted("T at %g Hz, dB", f), decibels(record.nominal.gain(i)),
               tally.gain_db[at], in_decibels(tally.gain[at]), decibels(tally.gain[at].most), same,
               "%.2f");
  }
  add_spread(table, "peak of T, dB", decibels(record.nominal.peak), tally.peak_db,
             in_decibels(tally.peak), decibels(tally.peak.most), same, "%.2f");
  add_spread(table, "slowest decay, 1/s", record.nominal.decay, tally.decay, decay_extremes(record),
             -std::log(tally.radius.most) / record.sample_time, power, "%.3g");
  add_spread(table, "least damping ratio", record.nominal.damping, tally.least_damping,
             tally.damping, tally.damping.least, same, "%.3g");
  return "T is the largest singular value from the floor to the frame, of stable loops\n" +
         table.print() +
         formatted(
             "Under a percentage: the middle of its bin, within what was found. Bins are %g dB, %g "
             "decades of decay and\n%g decades of damping ratio wide\n",
             tally.peak_db.width, tally.decay.width, tally.least_damping.above.width);
}

std::string worst_table(const Tally& tally) {
  constexpr const char* by[] = {"spectral radius", "least damping", "peak of T"};
  Table table({"worst by", "sample", "spectral radius", "damping ratio", "peak of T, dB"}, 1);
  for (const Measure measure : robustness::measures) {
    const auto m = static_cast<size_t>(measure);
    const auto& list = tally.worst[m];
    for (size_t i = 0; i < std::min(n_worst_shown, list.size()); ++i) {
      table.add(
          {i == 0 ? by[m] : "", formatted("%llu", static_cast<unsigned long long>(list[i].index)),
           formatted("%.6f", list[i].radius), formatted("%.3g", list[i].damping),
           std::isnan(list[i].peak) ? "unstable" : formatted("%.2f", decibels(list[i].peak))});
    }
  }
  return table.print();
}

}  // namespace

Extremes in_decibels(const Extremes& values) {
  return {.least = decibels(values.least), .most = decibels(values.most)};
}

namespace {

double within(double middle, const Extremes& extremes) {
  return std::isnan(middle) ? middle : std::clamp(middle, extremes.least, extremes.most);
}

}  // namespace

double quantile_within(const Histogram& histogram, const Extremes& extremes, double share) {
  return within(histogram.quantile(share), extremes);
}

double quantile_within(const robustness::RatioHistogram& histogram, const Extremes& extremes,
                       double share) {
  return within(histogram.quantile(share), extremes);
}

BadShare bad_share(const Tally& tally) {
  const std::uint64_t n = tally.n_samples(), bad = tally.n_unstable + tally.n_failed();
  return {n > 0 ? static_cast<double>(bad) / static_cast<double>(n) : 0,
          robustness::upper_bound_of_share(bad, n)};
}

std::string page_of(const Record& record) {
  std::string text = record.scene + "\n" + count_lines(record);
  if (record.tally.n_stable + record.tally.n_unstable == 0) return text;
  return text + "\n" + spread_table(record) + "\n" + worst_table(record.tally);
}

namespace {

std::string verdict_text(const Outcome& outcome) {
  switch (outcome.verdict) {
    case Outcome::Verdict::failed:
      return outcome.failure;
    case Outcome::Verdict::unstable:
      return formatted("unstable, spectral radius %.6f", outcome.radius);
    case Outcome::Verdict::stable:
      break;
  }
  return formatted("stable, spectral radius %.6f, damping ratio %.3g, peak of T %.2f dB",
                   outcome.radius, outcome.damping, decibels(outcome.peak));
}

/// "  stiffness +10 %: leg_1, leg_2; -10 %: leg_3", in lines of 100 characters.
std::string kind_lines(Parameter::Kind kind, const std::vector<Parameter>& parameters,
                       const Eigen::VectorXd& values) {
  std::map<std::string, std::string> subjects;  // by deviation
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].kind != kind) continue;
    const double value = values(static_cast<Eigen::Index>(i));
    std::string& list = subjects[robustness::deviation_text(parameters[i], value)];
    list += (list.empty() ? "" : ", ") + robustness::subject_text(parameters[i]);
  }
  std::string text, line = "  " + robustness::kind_text(kind);
  for (const auto& [deviation, list] : subjects) {
    std::istringstream words(" " + deviation + (list.empty() ? "" : ": " + list) +
                             (deviation == subjects.rbegin()->first ? "" : ";"));
    for (std::string word; words >> word;) {
      if (line.size() + word.size() > 98) {
        text += line + "\n";
        line = "   ";
      }
      line += " " + word;
    }
  }
  return text + line + "\n";
}

}  // namespace

std::string page_of(const robustness::WorstCase& worst, Measure measure,
                    const std::vector<Parameter>& parameters) {
  constexpr const char* by[] = {"spectral radius", "damping", "peak of T"};
  const bool stable = worst.outcome.verdict == Outcome::Verdict::stable;
  std::string text = formatted("By %s, in %llu evaluations: ", by[static_cast<size_t>(measure)],
                               static_cast<unsigned long long>(worst.evaluations));
  if (measure != Measure::radius && !stable) return text + "an unstable loop\n";
  text += verdict_text(worst.outcome) + "\n";
  if (!stable) {
    text += formatted("  up to %.0f %% of these deviations together the loop is stable:\n",
                      100 * worst.stable_part);
  }
  for (const auto& [kind, without] : worst.without) {
    text += kind_lines(kind, parameters, worst.values);
  }
  for (const auto& [kind, without] : worst.without) {
    if (worst.without.size() < 2) break;
    text += "  without the " + robustness::kind_text(kind) + ": " + verdict_text(without) + "\n";
  }
  return text;
}

}  // namespace stillframe::tools

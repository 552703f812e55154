#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "core/systems/sampled_loop.hpp"
#include "judge/page_of.hpp"
#include "judge/verdict_of.hpp"
#include "report/export/log_export.hpp"
#include "report/page/write_page.hpp"
#include "report/spectra/spectra.hpp"
#include "report/verdict/motion_level.hpp"
#include "tests/random_scenes/loop_run.hpp"
#include "tests/random_scenes/relation.hpp"
#include "tests/support/scratch_folder.hpp"
#include "tools/run/single_process.hpp"

namespace stillframe::random_scenes {

namespace {

/// How many words of a text are numbers that are none.
int count_not_finite(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return std::isalnum(c) ? static_cast<char>(std::tolower(c)) : ' ';
  });
  std::istringstream words(text);
  int n = 0;
  for (std::string word; words >> word;) n += word == "nan" || word == "inf" || word == "infinity";
  return n;
}

/// Rows of numbers behind a header; a cell that is none is NaN.
Eigen::MatrixXd read_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');)
      row.push_back(std::strtod(cell.c_str(), nullptr));
    rows.push_back(row);
  }
  Eigen::MatrixXd values(static_cast<Index>(rows.size()),
                         rows.empty() ? 0 : static_cast<Index>(rows[0].size()));
  for (Index i = 0; i < values.rows(); ++i) {
    for (Index j = 0; j < values.cols(); ++j)
      values(i, j) = rows[static_cast<size_t>(i)].at(static_cast<size_t>(j));
  }
  return values;
}

/// How many nulls of a verdict stand where a number belongs: a number that is not finite is null.
int count_nulls(const nlohmann::json& value, double rate) {
  // Documented as null where there is none.
  static const std::set<std::string> optional = {"isolates_above_hz",
                                                 "real_time_factor",
                                                 "force_limit_n",
                                                 "share",
                                                 "settling_s",
                                                 "floor_rms_m_s2",
                                                 "passive_rms_m_s2",
                                                 "active_rms_m_s2",
                                                 "active_by_forces_m_s2",
                                                 "active_undisturbed_m_s2"};
  const bool missing = value.is_object() && !value.value("missing", "").empty();
  int n = 0;
  for (const auto& [key, item] : value.items()) {
    // Quotients of numbers that are looked at, null for 0 / 0; what is not known at a frequency.
    if (key.starts_with("ratio_") || key == "transmissibility") continue;
    if (key == "third_octaves_m_s" || key == "cumulative_rms_m_s2") {
      const auto bands = report::third_octave_bands();
      for (size_t i = 0; i < bands.size(); ++i) {
        n += item.at(i).is_null() && bands[i].upper_hz <= 0.5 * rate;
      }
    } else if (item.is_structured()) {
      n += count_nulls(item, rate);
    } else {
      n += item.is_null() && !missing && !optional.count(key);
    }
  }
  return n;
}

/// What of the mean square of x, less its mean, lies between two frequencies (Hz): the square of
/// its Fourier integral, summed over frequencies that are near enough for records up to 32 s.
double power_between(const Eigen::VectorXd& x, double rate, double lower_hz, double upper_hz) {
  constexpr double step = 1.0 / 64;
  const Eigen::VectorXd y = x.array() - x.mean();
  double sum = 0;
  for (double f = lower_hz + step / 2; f < std::min(upper_hz, rate / 2); f += step) {
    const std::complex<double> turn = std::polar(1.0, 2 * std::numbers::pi * f / rate);
    std::complex<double> value = 0;
    for (Index k = y.size(); k-- > 0;) value = value * turn + y(k);
    sum += std::norm(value);
  }
  return 2 * step * sum / (rate * static_cast<double>(x.size()));
}

/// The stated rms of 1 to 80 Hz against the samples themselves.
void check_level(const report::MotionLevel& level, const Eigen::VectorXd& x, double rate,
                 const std::string& what, Finding& finding) {
  const auto power = [&](double lower, double upper) {
    return power_between(x, rate, lower, upper);
  };
  const double direct = power(report::lowest_level_hz, report::highest_level_hz);
  // An edge is known to 1/8 Hz (docs/identification.md).
  double edges = 0;
  for (const double f : {report::lowest_level_hz, report::highest_level_hz}) {
    edges += power(f - 0.125, f + 0.125);
  }
  finding.take(std::abs(level.rms_acceleration * level.rms_acceleration - direct),
               edges + 1e-3 * direct, what + ", square of the rms", direct);
}

}  // namespace

std::optional<Finding> check_report(Case& scene, std::uint64_t) {
  if (!scene.has_loop() || !scene.floor()) return std::nullopt;
  const judge::LoopDesign& design = scene.design();
  const test::ScratchFolder folder;
  std::optional<tools::RunDirectory> directory(folder.path() / "run");
  const std::string floor_text =
      YamlReader::from_text(scene.text(), "scene").require("floor").dump();
  judge::RunAnalyses runs;
  Finding finding;
  std::vector<std::string> loops = {"passive"};
  std::map<std::string, Eigen::MatrixXd> accelerations;
  if (design.radius < largest_stable_radius) loops.push_back("active");
  // What the runs show directly, all as far as the dearest of them goes; less far than where
  // methods are compared, as all are run again for the log, and no accuracy is asked for.
  const Index whole = run_samples(scene) + 1;
  Index n = whole;
  std::map<std::string, Signals> shown;
  for (const std::string& loop : loops) {
    shown[loop] = run_loop(scene.scene(), design, floor::make_floor_source(*scene.floor()), n,
                           loop == "active", affordable_evaluations(scene) / 6);
    n = shown[loop].n_samples();
  }
  if (too_short(finding, "the runs", n, whole)) return finding;
  for (const std::string& loop : loops) {
    Signals& direct = shown[loop];
    direct.shorten(n);
    tools::PhaseOptions options;
    options.loop = loop;
    options.mode = "single_process";
    options.run_id = 1;
    options.sample_rate_hz = design.gains.sample_rate_hz;
    options.duration_s = static_cast<double>(n - 1) / options.sample_rate_hz;
    const auto result =
        tools::run_in_process(design, *scene.floor(), floor_text, options, *directory);
    if (result.exit_code != 0) throw std::runtime_error(result.reason);
    const auto log = *directory / (loop + ".lcm");
    runs.add(judge::analyse_run(log));
    // The export has what the same run shows directly, to the bit.
    const auto csv = *directory / (loop + ".csv");
    report::export_csv(log, {.run_id = {}, .channels = {}, .progress = [](double) {}}, csv);
    const Eigen::MatrixXd exported = read_csv(csv);
    const Index m = direct.sigma.cols(), n_floor = static_cast<Index>(scene.scene().inputs.size()),
                n_frame = direct.acceleration.cols();
    // seq, time_s, floor, sigma, applied, frame, command.
    if (exported.rows() != n || exported.cols() != 2 + n_floor + 3 * m + n_frame) {
      finding.take(1, 0, "size of the export");
      return finding;
    }
    const auto same = [&](Index column, const Eigen::MatrixXd& values, const char* what) {
      // Of each number, as NaN is equal to none.
      const bool all = (exported.middleCols(column, values.cols()).array() == values.array()).all();
      finding.take(all ? 0 : 1, 0.5, what);
    };
    same(2 + n_floor, direct.sigma, "exported sigma");
    same(2 + n_floor + 2 * m, direct.acceleration, "exported acceleration");
    same(2 + n_floor + 2 * m + n_frame, direct.force, "exported command");
    accelerations[loop] = direct.acceleration;
  }
  const report::Verdict verdict = judge::verdict_of(runs);
  const double rate = design.gains.sample_rate_hz;
  for (const report::AxisLevels& axis : verdict.axes) {
    const Scene& own = scene.scene();
    const auto named = [](const auto& list, const std::string& name) {
      return std::find_if(list.begin(), list.end(),
                          [&](const auto& item) { return item.name == name; });
    };
    const auto check = [&](const std::optional<report::MotionLevel>& level, const char* loop,
                           const std::string& signal) {
      if (!level || !accelerations.count(loop)) return;
      auto signals = own.outputs;
      signals.insert(signals.end(), own.monitors.begin(), own.monitors.end());
      const Index column = named(signals, signal) - signals.begin();
      check_level(*level, accelerations[loop].col(column), rate, signal + ", " + loop, finding);
    };
    const SceneComparison& comparison = *named(own.comparisons, axis.axis);
    check(axis.floor, loops.back().c_str(), comparison.floor);
    check(axis.passive, "passive", comparison.frame);
    check(axis.active, "active", comparison.frame);
  }
  finding.take(count_nulls(nlohmann::json::parse(report::to_json(verdict)), rate), 0.5,
               "numbers in the verdict's JSON that are none");
  finding.take(count_not_finite(report::to_text(verdict)), 0.5,
               "numbers in the verdict's text that are none");
  page::write_page(judge::page_of(runs, verdict), folder.path() / "report.html");
  return finding;
}

}  // namespace stillframe::random_scenes

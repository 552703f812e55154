#include "bench/work_precision_page.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/errors/formatted.hpp"
#include "core/mechanics/scene/plant_methods.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_style.hpp"

namespace stillframe {

using nlohmann::json;

namespace {

constexpr const char* colours[] = {"'#000000'", "'#D55E00'", "'#0072B2'", "'#009E73'", "'#CC79A7'",
                                   "'#E69F00'", "'#56B4E9'", "'#6E6E6E'", "'#882255'", "'#117733'"};

const std::string automatic = method_name(PlantMethod::automatic);
const std::string linear = method_name(PlantMethod::linear);

double error_of(const json& point) {
  return std::max(point.at("error_acceleration").get<double>(),
                  point.at("error_sigma").get<double>());
}

/// The nonlinear point that is at least as good as the default's for the least time.
std::string envelope_line(const json& scene) {
  const json *standard = nullptr, *best = nullptr;
  for (const json& point : scene.at("points")) {
    if (point.contains("skipped")) continue;
    if (point.at("method") == automatic && point.at("setting") == 1e-5) standard = &point;
  }
  if (standard == nullptr) return "The default could not be run.\n";
  for (const json& point : scene.at("points")) {
    if (point.contains("skipped") || point.at("method") == automatic) continue;
    if (point.at("method") == linear || error_of(point) > error_of(*standard)) continue;
    if (best == nullptr || point.at("us_per_sample") < best->at("us_per_sample")) best = &point;
  }
  const double time = standard->at("us_per_sample");
  std::string line = "Default: " + formatted("%.3g", time) + " us a sample at an error of " +
                     formatted("%.1e", error_of(*standard)) + ". ";
  if (best == nullptr) return line + "Nothing else is as accurate.\n";
  return line + "The cheapest that is at least as accurate is " +
         best->at("method").get<std::string>() + " at " +
         formatted("%g", best->at("setting").get<double>()) + ", with " +
         formatted("%.2f", best->at("us_per_sample").get<double>() / time) + " of its time.\n";
}

std::string file_name(const std::string& scene) {
  std::string name = "speed_" + scene + ".png";
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

std::string scene_markdown(const json& scene) {
  const auto name = scene.at("scene").get<std::string>();
  std::string text =
      "### " + std::string(1, static_cast<char>(std::toupper(name[0]))) + name.substr(1) + "\n\n`" +
      scene.at("file").get<std::string>() + ".yaml`, " +
      std::to_string(scene.at("samples").get<int>()) + " samples. The references, `" +
      method_name(PlantMethod::nodal) + "` and `" + scene.at("minimal").get<std::string>() +
      "`, differ by " + formatted("%.1e", scene.at("known_acceleration").get<double>()) +
      " in the accelerations and " + formatted("%.1e", scene.at("known_sigma").get<double>()) +
      " in sigma: no error below is known. " + envelope_line(scene) +
      "\n![Error against time](images/" + file_name(name) +
      ")\n\n| method | tolerance | us a sample | evaluations | error of "
      "accelerations | error of sigma |\n|---|---|---|---|---|---|\n";
  for (const json& point : scene.at("points")) {
    text += "| `" + point.at("method").get<std::string>() + "` | " +
            formatted("%g", point.at("setting").get<double>()) + " | ";
    if (point.contains("skipped")) {
      text += point.at("skipped").get<std::string>() + " | | | |\n";
      continue;
    }
    text += formatted("%.3g", point.at("us_per_sample").get<double>()) + " | " +
            formatted("%.1f", point.at("evaluations_per_sample").get<double>()) + " | " +
            formatted("%.1e", point.at("error_acceleration").get<double>()) + " | " +
            formatted("%.1e", point.at("error_sigma").get<double>()) + " |\n";
  }
  return text + "\n";
}

void plot_scene(const json& scene, const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::vector<std::vector<Eigen::Vector2d>> curves;
  for (const json& point : scene.at("points")) {
    const auto method = point.at("method").get<std::string>();
    if (point.contains("skipped") || method == automatic) continue;
    if (names.empty() || names.back() != method) {
      names.push_back(method);
      curves.emplace_back();
    }
    curves.back().emplace_back(point.at("us_per_sample").get<double>(),
                               point.at("error_acceleration").get<double>());
  }
  std::string script =
      report::frame_style() + report::margins(0.11, 0.72, 0.13, 0.9) + "set title " +
      report::plot_text(scene.at("scene").get<std::string>()) +
      "\nset logscale xy\nset format xy '10^{%T}'\nset grid\n"
      "set xlabel 'time a sample (us)'\n"
      "set ylabel 'relative error of the accelerations'\n"
      "set key at screen 0.99, screen 0.9 right top vertical maxrows 12 maxcols 1\n";
  std::vector<std::string> parts;
  for (size_t i = 0; i < names.size(); ++i) {
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(curves[i].size()), 2);
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {
      rows.row(r) = curves[i][static_cast<size_t>(r)].transpose();
    }
    const std::string data = "curve" + std::to_string(i);
    script += report::plot_data(data, rows);
    parts.push_back("$" + data + " using 1:2 with linespoints linewidth 2 pointtype " +
                    std::to_string(i + 4) + " linecolor rgb " + colours[i % std::size(colours)] +
                    " title " + report::plot_text(names[i]));
  }
  report::run_gnuplot(script + "plot " + report::joined(parts) + "\n",
                      folder / file_name(scene.at("scene").get<std::string>()));
}

}  // namespace

std::string work_precision_markdown(const json& result) {
  std::string text;
  for (const json& scene : result.at("scenes")) text += scene_markdown(scene);
  return text;
}

std::string honesty_markdown(const json& rows) {
  std::vector<std::string> methods;
  for (const NamedPlantMethod& each : plant_methods) {
    if (each.method != PlantMethod::linear) methods.emplace_back(each.name);
  }
  std::string text = "| scene | floor m/s^2 | references differ by |", rule = "|---|---|---|";
  for (const auto& method : methods) {
    text += " `" + method + "` |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const json& row : rows) {
    text += "| " + row.at("scene").get<std::string>() + " | " +
            formatted("%g", row.at("floor").get<double>()) + " | ";
    if (row.contains("skipped")) {
      text += row.at("skipped").get<std::string>() + " |";
      for (size_t i = 0; i < methods.size(); ++i) text += " |";
      text += "\n";
      continue;
    }
    text += formatted("%.0e", row.at("known").get<double>()) + " | ";
    for (const auto& method : methods) {
      text += formatted("%.2g", row.at(method).at(0).get<double>()) + ", " +
              formatted("%.2g", row.at(method).at(1).get<double>()) + " | ";
    }
    text.pop_back();
    text += "\n";
  }
  return text;
}

void plot_work_precision(const json& result, const std::filesystem::path& folder) {
  for (const json& scene : result.at("scenes")) plot_scene(scene, folder);
}

}  // namespace stillframe

#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace stillframe {

/// What bench_work_precision found, as Markdown: for each scene a table of time and error, and
/// whether the default is on the lower envelope.
std::string work_precision_markdown(const nlohmann::json& result);

/// The same of the errors in tolerances: a row a scene and drive.
std::string honesty_markdown(const nlohmann::json& rows);

/// One picture a scene, error of the accelerations against time a sample: FOLDER/speed_SCENE.png.
/// Errors: InputError as run_gnuplot.
void plot_work_precision(const nlohmann::json& result, const std::filesystem::path& folder);

}  // namespace stillframe

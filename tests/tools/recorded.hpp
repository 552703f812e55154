#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "judge/run_analysis.hpp"

namespace stillframe::test {

struct RecordOptions {
  std::optional<std::filesystem::path> controller = {}, floor = {};
  std::optional<double> duration_s = {};
  std::vector<std::string> loops = {"passive", "active"};
};

/// The logs that `run --mode single_process` leaves, by the function that it calls. Nothing is
/// judged and no page is written: for tests that look at the logs, or judge them by judged().
void record(const std::filesystem::path& scene, const std::filesystem::path& out,
            const RecordOptions& options = {});

/// verdict.json of logs, as `run` and `report` come to it.
nlohmann::json judged(const judge::RunAnalyses& runs);
nlohmann::json judged(const std::vector<std::filesystem::path>& logs);
/// Of both logs of a run directory.
nlohmann::json judged(const std::filesystem::path& folder);

}  // namespace stillframe::test

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "report/verdict/verdict.hpp"

namespace stillframe::tools {

/// One run of a batch: a scene with the blocks that replace its own.
struct StudyCase {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, floor;
};

/// What came of it, passive and active, in one process and without a log.
struct StudyResult {
  std::string failure;  ///< why there is no result; empty: there is one
  std::string method;   ///< of the plant
  std::int64_t n_samples = 0;
  report::Verdict verdict;  ///< its runs, the scene's comparisons, and how they are judged
  double peak_force = 0, rms_force = 0;  ///< N, of the active loop, over all legs
  double times_real_time = 0;            ///< plant time over wall time, both loops
};

/// Runs one case. Never throws: what is wrong with it is its failure.
StudyResult run_case(const StudyCase& study, std::optional<double> duration_s) noexcept;

/// Runs all cases on so many threads, each case on one; results are in the order of the cases and
/// the same on any number of threads. done: called from one thread at a time as cases end.
std::vector<StudyResult> run_cases(const std::vector<StudyCase>& cases,
                                   std::optional<double> duration_s, int jobs,
                                   const std::function<void(std::size_t n_done)>& done);

}  // namespace stillframe::tools

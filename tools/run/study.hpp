#pragma once

#include <filesystem>
#include <optional>
#include <string>

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

/// What a case is of, by hashes of the scene with its controller block, and of the floor block with
/// all recordings. Errors: InputError of files that are missing or no such blocks.
struct StudyHashes {
  std::string scene, floor;
};
StudyHashes hashes_of(const StudyCase& study);

}  // namespace stillframe::tools

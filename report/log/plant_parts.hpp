#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::report {

/// What one plant measured of a run. A plant that is killed and started again for the same run
/// counts its samples from 0 again, on a floor of its own: nothing of the one belongs to the other.
struct PlantPart {
  std::int64_t instance = 0;   ///< measurement_t.plant_instance; 0: of a run in one process
  std::int64_t n_samples = 0;  ///< measurements, repeats left out
  bool described = false;      ///< by a run_info of its own
};

/// The plants of a run in the order in which they ended, those of fewer than 16 measurements left
/// out unless a run_info is theirs: a number that nobody but a few damaged messages has is no
/// plant. Reads the whole log, of each measurement only its head. Errors: InputError for a file
/// that cannot be read.
std::vector<PlantPart> plants_of_run(const std::filesystem::path& log, std::int64_t run_id,
                                     const std::function<void(double)>& progress);

/// Which of them is read: number `wanted`, counted from 1, else the last one that is described,
/// else the last one. Errors: InputError if there is no such plant, or it is not described while
/// others are.
std::size_t choose_plant(const std::vector<PlantPart>& plants, std::optional<int> wanted,
                         std::int64_t run_id, const std::string& place);

/// What a reader has to know of a run that several plants measured, a clause without its full stop;
/// nothing of any other run.
std::string plants_in_words(const std::vector<PlantPart>& plants, std::size_t chosen,
                            std::int64_t run_id);

}  // namespace stillframe::report

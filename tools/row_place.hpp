#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cli/command.hpp"
#include "core/control/robustness/monte_carlo.hpp"
#include "tools/row_file.hpp"

namespace stillframe::tools {

/// Where the rows of a study are computed and kept: --shard, --on, --out.
struct RowPlace {
  robustness::Shard shard;
  std::optional<std::size_t> n_tasks;  ///< of Slurm
  std::optional<std::filesystem::path> out;
};

void add_row_place(cli::Command& verb, const std::string& shard_help, std::string& shard,
                   std::string& on, std::optional<std::filesystem::path>& out);

/// Of these options. Errors: InputError.
RowPlace row_place(const std::string& shard, const std::string& on,
                   const std::optional<std::filesystem::path>& out);

/// The rows of the shard, in order; nothing where they are left to Slurm, and that was told.
/// Errors: those of RowFile, fill_rows, submit_to_slurm.
std::optional<std::vector<Json>> rows_at(const RowPlace& place, const RowStudy& study,
                                         const RowKind& kind, int jobs);

}  // namespace stillframe::tools

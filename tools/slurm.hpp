#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace stillframe::tools {

/// How many tasks --on slurm:N asks for, nothing where it is empty. Errors: InputError.
std::optional<std::size_t> parse_on(const std::string& text);

/// Has Slurm compute what this process was asked for: OUT.sbatch runs the same command line in at
/// most so many tasks, of a shard each, with rows in files of their own, and a job after them that
/// puts them together in OUT. Answers what to tell. Errors: Failure where sbatch is not there or
/// refuses; those of WholeFile.
std::string submit_to_slurm(const std::filesystem::path& out, std::size_t n_tasks);

}  // namespace stillframe::tools

#pragma once

#include <CLI/CLI.hpp>
#include <stdexcept>

// The verbs of `stillframe`, a file each: every function adds its subcommand to the program. What a
// verb does runs after the whole command line has been parsed; it answers through exit_code.
namespace stillframe::tools {

inline constexpr int exit_done = 0, exit_error = 1, exit_bad_input = 2, exit_refused = 3,
                     exit_failed = 4;

/// What was to be done has not come about, though everything was in order: exit code 4.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

void add_modes(CLI::App& app, int& exit_code);
void add_equilibrium(CLI::App& app, int& exit_code);
void add_buckling(CLI::App& app, int& exit_code);
void add_linearise(CLI::App& app, int& exit_code);
void add_sigma(CLI::App& app, int& exit_code);
void add_design(CLI::App& app, int& exit_code);
void add_budget(CLI::App& app, int& exit_code);
void add_robustness(CLI::App& app, int& exit_code);
void add_merge(CLI::App& app, int& exit_code);
void add_run(CLI::App& app, int& exit_code);
void add_identify(CLI::App& app, int& exit_code);
void add_report(CLI::App& app, int& exit_code);
void add_batch(CLI::App& app, int& exit_code);
void add_ctl(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_watch(CLI::App& app, int& exit_code);

}  // namespace stillframe::tools

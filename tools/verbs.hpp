#pragma once

#include <stdexcept>

#include "core/cli/command.hpp"

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

void add_modes(cli::Command& app, int& exit_code);
void add_equilibrium(cli::Command& app, int& exit_code);
void add_buckling(cli::Command& app, int& exit_code);
void add_linearise(cli::Command& app, int& exit_code);
void add_sigma(cli::Command& app, int& exit_code);
void add_superelement(cli::Command& app, int& exit_code);
void add_import(cli::Command& app, int& exit_code);
void add_design(cli::Command& app, int& exit_code);
void add_feedback(cli::Command& app, int& exit_code);
void add_budget(cli::Command& app, int& exit_code);
void add_robustness(cli::Command& app, int& exit_code);
void add_merge(cli::Command& app, int& exit_code);
void add_sweep(cli::Command& app, int& exit_code);
void add_run(cli::Command& app, int& exit_code);
void add_identify(cli::Command& app, int& exit_code);
void add_report(cli::Command& app, int& exit_code);
void add_batch(cli::Command& app, int& exit_code);
void add_ctl(cli::Command& app, int& exit_code);
void add_replay(cli::Command& app, int& exit_code);
void add_export(cli::Command& app, int& exit_code);
void add_rig(cli::Command& app, int& exit_code);
void add_commission(cli::Command& app, int& exit_code);
void add_watch(cli::Command& app, int& exit_code);

}  // namespace stillframe::tools

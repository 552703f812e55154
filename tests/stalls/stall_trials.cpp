#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>

#include "core/cli/command.hpp"
#include "tests/stalls/trials.hpp"

namespace stillframe::stalls {

namespace {

struct Options {
  int n_trials = 1000, n_of_a_batch = 20;
  std::string only;
  std::filesystem::path controller;
};

struct Row {
  std::vector<Trial> trials;
  std::int64_t n_batches = 0, n_commands = 0, n_two_forces = 0;
  std::size_t n_failures = 0;
};

/// The largest, what the machine took not taken off.
template <class Part>
double worst(const std::vector<Trial>& trials, Part part) {
  double most = 0;
  for (const Trial& trial : trials) most = std::max(most, part(trial));
  return most;
}

double median(const std::vector<Trial>& trials) {
  std::vector<double> all;
  for (const Trial& trial : trials) all.push_back(trial.obeyed_s);
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

void print(const std::map<std::string, Row>& rows) {
  std::printf(
      "| stall | stops | obeyed, median | obeyed, worst | told, worst | machine, worst | commands "
      "| "
      "two forces | failures |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [name, row] : rows) {
    std::printf("| %s | %zu | %.1f ms | %.1f ms | %.1f ms | %.1f ms | %lld | %lld | %zu |\n",
                name.c_str(), row.trials.size(), 1e3 * median(row.trials),
                1e3 * worst(row.trials, [](const Trial& t) { return t.obeyed_s; }),
                1e3 * worst(row.trials, [](const Trial& t) { return t.told_s; }),
                1e3 * worst(row.trials, [](const Trial& t) { return t.machine_s; }),
                static_cast<long long>(row.n_commands), static_cast<long long>(row.n_two_forces),
                row.n_failures);
  }
}

int run(const Options& options) {
  faults::Workbench bench;
  std::vector<Stall> stalls;
  for (Stall& stall : all_stalls()) {
    if (stall.name.find(options.only) != std::string::npos) stalls.push_back(std::move(stall));
  }
  if (stalls.empty()) throw std::runtime_error("--only: no stall has that in its name");
  std::map<std::string, Row> rows;
  std::size_t n_failures = 0;
  BatchOptions batch_options{
      .n_trials = options.n_of_a_batch, .seed = 0, .controller = options.controller};
  for (int n = 0, i = 0; n < options.n_trials; ++i) {
    const Stall& stall = stalls[static_cast<std::size_t>(i) % stalls.size()];
    ++batch_options.seed;
    const Batch batch = run_batch(bench, stall, batch_options);
    n += static_cast<int>(std::max<std::size_t>(batch.trials.size(), 1));
    Row& row = rows[stall.name];
    row.trials.insert(row.trials.end(), batch.trials.begin(), batch.trials.end());
    row.n_commands += batch.n_commands;
    row.n_two_forces += batch.n_two_forces;
    row.n_failures += batch.failures.size();
    n_failures += batch.failures.size();
    for (const std::string& failure : batch.failures) std::cerr << failure << "\n";
    std::cerr << n << " of " << options.n_trials << "\n";
  }
  print(rows);
  return n_failures == 0 ? 0 : 4;
}

}  // namespace

}  // namespace stillframe::stalls

int main(int argc, char** argv) {
  using namespace stillframe::stalls;
  stillframe::cli::Command app(
      "Stops a controller by the clock again and again while its terminal, its disk or itself is "
      "stalled and another controller wants its place.\nExit codes: 0 all as it should be, 2 bad "
      "usage, 4 not.",
      "stall_trials");
  Options options;
  app.option("--trials", options.n_trials, "Stops in all")
      .check(stillframe::cli::whole_number(1, 1'000'000))
      .show_default();
  app.option("--batch", options.n_of_a_batch, "Stops of each controller process")
      .check(stillframe::cli::whole_number(1, 100))
      .show_default();
  app.option("--only", options.only, "Only stalls whose name has this in it");
  app.option("--controller", options.controller, "Another program in the controller's place")
      .check(stillframe::cli::existing_file());
  try {
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(options);
  } catch (const std::exception& error) {
    std::cerr << "stall_trials: " << error.what() << "\n";
    return 4;
  }
}

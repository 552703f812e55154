#include <cstdio>
#include <exception>
#include <iostream>

#include "core/cli/command.hpp"
#include "tests/faults/table.hpp"

namespace stillframe::faults {

namespace {

struct Options {
  int n_seeds = 10;
  double leg_damping = Workbench::default_leg_damping;
  bool json = false;
  std::string only, policy;
  std::filesystem::path samples;
};

std::vector<Kind> chosen(const Options& options) {
  std::vector<Kind> kinds;
  for (Kind& kind : all_kinds()) {
    if (kind.name.find(options.only) != std::string::npos) kinds.push_back(std::move(kind));
  }
  return kinds;
}

int run(const Options& options) {
  Workbench bench(options.leg_damping);
  TableOptions table{.seeds = {}, .policy = options.policy, .samples = options.samples};
  for (int i = 1; i <= options.n_seeds; ++i) table.seeds.push_back(static_cast<std::uint64_t>(i));
  const auto results = run_kinds(bench, chosen(options), table);
  if (options.json) {
    std::cout << to_json(results).dump(1) << "\n";
  } else {
    std::cout << markdown(results);
  }
  bool failed = false;
  for (const KindResult& result : results) {
    for (const std::string& failure : failures(result)) {
      std::cerr << failure << "\n";
      failed = true;
    }
  }
  return failed ? 4 : 0;
}

}  // namespace

}  // namespace stillframe::faults

int main(int argc, char** argv) {
  using namespace stillframe::faults;
  stillframe::cli::Command app(
      "Runs every fault of the table against a plant and a controller, and prints what came of "
      "it.\nExit codes: 0 all as it should be, 2 bad usage, 4 not.",
      "fault_table");
  Options options;
  app.option("--seeds", options.n_seeds, "Episodes of each fault")
      .check(stillframe::cli::whole_number(1, 1000))
      .show_default();
  app.option("--damping", options.leg_damping, "Of each leg, N s/m")
      .check(stillframe::cli::number_from_zero())
      .show_default();
  app.option("--only", options.only, "Only faults whose name has this in it");
  app.option("--policy", options.policy, "Text of a policy file, as in 'rejoin: {a_minute: 1}'");
  app.option("--samples", options.samples, "Write every sample of every run there, as CSV")
      .check(stillframe::cli::existing_folder());
  app.flag("--json", options.json, "JSON in the place of a table in Markdown");
  try {
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(options);
  } catch (const std::exception& error) {
    std::cerr << "fault_table: " << error.what() << "\n";
    return 4;
  }
}

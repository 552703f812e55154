#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

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
  CLI::App app(
      "Runs every fault of the table against a plant and a controller, and prints what came of "
      "it.\nExit codes: 0 all as it should be, 2 bad usage, 4 not.",
      "fault_table");
  Options options;
  app.add_option("--seeds", options.n_seeds, "Episodes of each fault")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--damping", options.leg_damping, "Of each leg, N s/m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--only", options.only, "Only faults whose name has this in it");
  app.add_option("--policy", options.policy,
                 "Text of a policy file, as in 'rejoin: {a_minute: 1}'");
  app.add_option("--samples", options.samples, "Write every sample of every run there, as CSV")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--json", options.json, "JSON in the place of a table in Markdown");
  try {
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::cerr << "fault_table: " << error.what() << "\n";
    return 4;
  }
}

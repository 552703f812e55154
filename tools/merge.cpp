#include <iostream>
#include <memory>

#include "tools/given_files.hpp"
#include "tools/robustness_file.hpp"
#include "tools/robustness_text.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct MergeOptions {
  std::vector<std::filesystem::path> files;
  std::filesystem::path out;
  bool json = false;
};

std::string missing_shards(const robustness::Record& record) {
  constexpr int most_named = 20;
  std::string list;
  int count = 0;
  for (std::uint64_t shard = 1; shard <= record.n_shards; ++shard) {
    if (record.shards.contains(shard)) continue;
    if (++count <= most_named) list += (list.empty() ? "" : ", ") + std::to_string(shard);
  }
  if (count > most_named) list += " and " + std::to_string(count - most_named) + " more";
  return list;
}

int run(const MergeOptions& options) {
  std::vector<GivenFile> read;
  for (const auto& file : options.files) read.push_back({"a record", file});
  require_own_places(read, {{"--out", options.out}});
  std::vector<robustness::NamedRecord> records;
  for (const auto& file : options.files) records.push_back({file.string(), read_record(file)});
  const robustness::Record all = merge_records(std::move(records));
  write_record(all, options.out);
  if (!all.complete()) {
    std::cerr << "stillframe: note: shards " << missing_shards(all) << " of " << all.n_shards
              << " are missing\n";
  }
  if (options.json) {
    print(to_json(all));
  } else {
    std::cout << page_of(all);
  }
  return exit_done;
}

}  // namespace

void add_merge(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<MergeOptions>();
  cli::Command verb =
      app.verb("merge", "Puts the records of `robustness --shard` together into one");
  verb.option("files", options->files, "Records that `stillframe robustness --out` wrote")
      .required()
      .type_name("FILE");
  verb.option("--out", options->out, "Write the record of all (JSON)").required().type_name("FILE");
  verb.flag("--json", options->json, "Print it as well (keys: stillframe robustness --help)");
  verb.footer(
      "The records must be of one scene, controller, uncertainty, seed and number of samples, and\n"
      "of different shards of one division. The record of all shards is, byte for byte, the one\n"
      "that a single run would have written. Shards that are missing are named in a note and can "
      "be\n"
      "merged later: shards.done in the record says which there are.\n"
      "Example: stillframe merge part_*.json --out all.json");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

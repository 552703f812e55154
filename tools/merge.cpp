#include <fstream>
#include <iostream>
#include <map>
#include <memory>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "tools/batch_rows.hpp"
#include "tools/given_files.hpp"
#include "tools/robustness_file.hpp"
#include "tools/robustness_text.hpp"
#include "tools/sweep_rows.hpp"
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

/// Of which study a file has rows, if of one. Errors: InputError of a file that has no JSON.
const RowKind* kind_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::getline(file, line);
  if (!line.empty() && line.find_first_of("{[") != 0) {
    throw InputError(path.string() +
                     ": found a file that is neither a record of `robustness` nor rows of `sweep` "
                     "or `batch`");
  }
  const Json row = Json::parse(line, nullptr, false);
  for (const RowKind* kind : {&sweep_rows, &batch_rows}) {
    if (is_row(row, *kind)) return kind;
  }
  return nullptr;
}

void require_file(const std::filesystem::path& path) {
  std::error_code missing;
  if (std::filesystem::is_regular_file(path, missing)) return;
  throw InputError(path.string() + ": cannot be read: there is no such file");
}

int merge_rows(const MergeOptions& options, const RowKind& kind) {
  if (options.json) {
    throw InputError("--json: rows are lines of JSON as they stand in " + options.out.string() +
                     "; leave it out");
  }
  struct Found {
    Json first, last;
  };
  std::map<std::string, Found> rows;
  std::size_t n_other = 0;
  for (const auto& path : options.files) {
    const RowFile file(path, kind);
    for (const auto& [key, row] : file.rows()) {
      const auto [known, is_new] = rows.try_emplace(key, Found{row, row});
      // A copy of what was known before says nothing against what was computed since.
      if (is_new || row == known->second.first || row == known->second.last) continue;
      known->second.last = row;
      ++n_other;
    }
    if (file.n_unfinished() > 0) {
      std::cerr << "stillframe: note: " << path.string() << ": " << file.n_unfinished()
                << " line(s) without an end, as of a program that was killed, do not count\n";
    }
  }
  if (n_other > 0) {
    std::cerr << "stillframe: note: " << n_other
              << " row(s) answer what an earlier one answers otherwise, and count in its place\n";
  }
  std::string text;
  for (const auto& [key, found] : rows) text += line_of(found.last);
  write_whole_file(options.out, text);
  std::cout << rows.size() << " rows of `" << kind.verb << "` in " << options.out.string() << "\n";
  return exit_done;
}

int run(const MergeOptions& options) {
  std::vector<GivenFile> read;
  for (const auto& file : options.files) read.push_back({"a record", file});
  require_own_places(read, {{"--out", options.out}});
  for (const auto& file : options.files) require_file(file);
  for (const auto& file : options.files) {
    // The first one with a line says what they are to be.
    if (const RowKind* kind = kind_of(file)) return merge_rows(options, *kind);
    if (!RowFile::is_half_a_row(file)) break;
  }
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
  cli::Command verb = app.verb(
      "merge", "Puts what the shards of robustness, sweep or batch wrote together in one file");
  verb.option("files", options->files, "Files that --out of one of these wrote")
      .required()
      .type_name("FILE");
  verb.option("--out", options->out, "Write the record, or the rows, of all")
      .required()
      .type_name("FILE");
  verb.flag("--json", options->json,
            "Print the record as well (keys: stillframe robustness --help)");
  verb.footer(
      "Records of `robustness` must be of one scene, controller, uncertainty, seed and number of "
      "samples, and\n"
      "of different shards of one division. The record of all shards is, byte for byte, the one\n"
      "that a single run would have written. Shards that are missing are named in a note and can "
      "be\n"
      "merged later: shards.done in the record says which there are.\n"
      "Rows of `sweep` and `batch` may be of any questions; of one that is there more than once "
      "the\n"
      "last that differs from the first counts, which is said, and the last line of a program that "
      "was killed\n"
      "does not.\n"
      "Example: stillframe merge part_*.json --out all.json");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

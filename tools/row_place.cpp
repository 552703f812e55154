#include "tools/row_place.hpp"

#include <algorithm>
#include <iostream>

#include "core/errors/input_error.hpp"
#include "tools/shard_option.hpp"
#include "tools/slurm.hpp"

namespace stillframe::tools {

void add_row_place(cli::Command& verb, const std::string& shard_help, std::string& shard,
                   std::string& on, std::optional<std::filesystem::path>& out) {
  verb.option("--shard", shard, shard_help).type_name("I/N");
  verb.option("--out", out, "File of rows that are kept and need not be computed again")
      .type_name("FILE");
  verb.option("--on", on, "Let Slurm compute it, in N tasks, into the file of --out")
      .type_name("slurm:N");
}

RowPlace row_place(const std::string& shard, const std::string& on,
                   const std::optional<std::filesystem::path>& out) {
  const RowPlace place{parse_shard(shard), parse_on(on), out};
  if (place.n_tasks && !shard.empty()) {
    throw InputError("--on: each of its tasks has a --shard of its own; leave yours out");
  }
  if (place.n_tasks && !out) throw InputError("--on: --out is missing, the file of the rows");
  return place;
}

std::optional<std::vector<Json>> rows_at(const RowPlace& place, const RowStudy& study,
                                         const RowKind& kind, int jobs) {
  std::optional<RowFile> file;
  if (place.out) file.emplace(*place.out, kind);
  if (place.n_tasks) {
    std::cout << submit_to_slurm(*place.out, std::min(*place.n_tasks, study.n_points));
    return std::nullopt;
  }
  std::vector<std::size_t> points(place.shard.size(study.n_points));
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = i * place.shard.of + place.shard.number - 1;
  }
  return fill_rows(study, points, jobs, file ? &*file : nullptr);
}

}  // namespace stillframe::tools

#include "controller/law_block.hpp"

#include "core/yaml/loop_numbers.hpp"

namespace stillframe::controller {

using Eigen::Index;

namespace {

std::vector<std::string> read_names(const YamlReader& list) {
  std::vector<std::string> names;
  for (const YamlReader& item : list.items()) names.push_back(item.text());
  if (names.empty()) list.fail("found no names, one at least is needed");
  return names;
}

}  // namespace

NamedLaw read_law_block(const YamlReader& reader) {
  NamedLaw law;
  law.inputs = read_names(reader.require("inputs"));
  law.outputs = read_names(reader.require("outputs"));
  const YamlReader A = reader.require("A");
  const Index n = std::ssize(A.items()), n_in = std::ssize(law.inputs),
              n_out = std::ssize(law.outputs);
  law.A = A.matrix(n, n, largest_entry);
  law.B = reader.require("B").matrix(n, n_in, largest_entry);
  law.C = reader.require("C").matrix(n_out, n, largest_entry);
  law.D = reader.require("D").matrix(n_out, n_in, largest_entry);
  return law;
}

}  // namespace stillframe::controller

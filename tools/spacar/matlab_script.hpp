#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tools/spacar/matlab_tokens.hpp"
#include "tools/spacar/matlab_value.hpp"
#include "tools/spacar/place.hpp"

namespace stillframe::tools::spacar {

/// What a script has put into a place such as nprops(3).force: the path of names and indices (0 for
/// none) from its variable down.
struct Assigned {
  std::vector<std::pair<std::string, int>> path;
  Value value;
  int line = 0;
};

/// A script after it was run up to its call of spacarlight.
struct Script {
  std::string name;
  std::map<std::string, std::pair<Value, int>> variables;  ///< with the line of each
  std::vector<Assigned> fields;                            ///< of structures, the last one of each
  /// Variables that could not be worked out: where, and why.
  std::map<std::string, std::pair<int, std::string>> unknown;
  std::vector<std::string> arguments;  ///< of the call, by name; "" for others
  int call_line = 0;
  int n_statements = 0;
  Remarks remarks;
  std::vector<std::string> given;  ///< assignments from outside
};

/// Runs what a model is written with: numbers, texts, matrices, ranges, arithmetic, the usual
/// functions, scalars and fields of structures. Everything else is a remark with its line, and what
/// it would have set is unknown from there on. Errors: InputError of what is no MATLAB, or of a
/// script without the call.
/// given: assignments of what the script has from elsewhere, before its first line.
Script run_script(const std::vector<std::string>& lines, const std::string& name,
                  const std::vector<std::string>& given = {});

}  // namespace stillframe::tools::spacar

#include "tools/shard_option.hpp"

#include <cstdio>

#include "core/errors/input_error.hpp"

namespace stillframe::tools {

robustness::Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  unsigned long long number = 0, of = 0;
  int end = 0;
  const bool reads = std::sscanf(text.c_str(), "%llu/%llu%n", &number, &of, &end) == 2 &&
                     static_cast<std::size_t>(end) == text.size() &&
                     text.find('-') == std::string::npos;
  if (!reads || number < 1 || number > of) {
    throw InputError("--shard: found '" + text + "', allowed is I/N with I from 1 to N");
  }
  return {number, of};
}

}  // namespace stillframe::tools

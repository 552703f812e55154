#pragma once

#include <fstream>
#include <string>

namespace stillframe {

/// What a time belongs to: the processor, and how the program was compiled.
inline std::string machine_line(const std::string& flags) {
  std::string processor = "unknown processor";
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    processor = line.substr(line.find(':') + 2);
    break;
  }
  return processor + "; GCC " __VERSION__ "; " + flags;
}

}  // namespace stillframe

#include "report/said_once.hpp"

#include <algorithm>

namespace stillframe::report {

void SaidOnce::add(const std::string& who, const std::string& what) {
  auto place = std::find_if(said_.begin(), said_.end(),
                            [&](const auto& said) { return said.second == what; });
  if (place == said_.end()) place = said_.insert(said_.end(), {{}, what});
  auto& names = place->first;
  if (std::find(names.begin(), names.end(), who) == names.end()) names.push_back(who);
}

void SaidOnce::add(const std::string& sentence) {
  const std::size_t colon = sentence.find(": ");
  if (colon == std::string::npos) return add("", sentence);
  add(sentence.substr(0, colon), sentence.substr(colon + 2));
}

std::vector<std::string> SaidOnce::lines() const {
  std::vector<std::string> lines;
  for (const auto& [names, what] : said_) {
    std::string line;
    for (const std::string& name : names) line += (line.empty() ? "" : "; ") + name;
    lines.push_back(line + (line.empty() ? "" : ": ") + what);
  }
  return lines;
}

}  // namespace stillframe::report

#pragma once

#include <string>
#include <vector>

namespace stillframe::tools {

/// What a page says of a loop in words, a sentence each.
struct Remarks {
  std::vector<std::string>
      warnings;                    ///< what a person should mend or know before it is switched on
  std::vector<std::string> notes;  ///< what it has, and what is known to do no harm

  void add(const Remarks& more) {
    warnings.insert(warnings.end(), more.warnings.begin(), more.warnings.end());
    notes.insert(notes.end(), more.notes.begin(), more.notes.end());
  }
};

}  // namespace stillframe::tools

#pragma once

#include <string>
#include <utility>
#include <vector>

namespace stillframe::report {

/// What is said of several things in the same words, once, with the names of all of them.
class SaidOnce {
 public:
  void add(const std::string& who, const std::string& what);
  /// "Axis x: it is short", whose name ends at the first ": "; a sentence without one is its own.
  void add(const std::string& sentence);
  /// One for each `what`, in the order of the first: "who; who; who: what".
  std::vector<std::string> lines() const;

 private:
  std::vector<std::pair<std::vector<std::string>, std::string>> said_;
};

}  // namespace stillframe::report

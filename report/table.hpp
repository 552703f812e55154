#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace stillframe::report {

/// A number of things, as the %lld of formatted() takes it.
inline long long count(std::int64_t n) { return n; }

/// Rows of cells under a header; the first n_text_columns stand to the left, the others to the
/// right.
class Table {
 public:
  Table(std::vector<std::string> header, std::size_t n_text_columns);
  void add(std::vector<std::string> row);
  std::string print() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::size_t n_text_columns_;
};

}  // namespace stillframe::report

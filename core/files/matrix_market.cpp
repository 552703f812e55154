#include "core/files/matrix_market.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"

namespace stillframe {

namespace {

using Eigen::Index;

/// Larger ones are no body that anybody could reduce in memory.
constexpr double largest_size = 10e6;

class Lines {
 public:
  Lines(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}
  /// The next line that is neither empty nor a comment; false at the end.
  bool next(std::string_view& line) {
    while (next_of_any_kind(line)) {
      if (line.find_first_not_of(" \t\r") != std::string_view::npos && line.front() != '%') {
        return true;
      }
    }
    return false;
  }
  bool next_of_any_kind(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }
  [[noreturn]] void fail(std::string_view found, const std::string& allowed) const {
    throw InputError(name_ + ":" + std::to_string(number_) + ": found '" + printable(found, 60) +
                     "', allowed " + allowed);
  }
  [[noreturn]] void fail_at_end(const std::string& lacks) const {
    throw InputError(name_ + ":" + std::to_string(number_) + ": the file ends, but " + lacks);
  }

 private:
  std::string_view rest_;
  const std::string& name_;
  long number_ = 0;
};

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : line) {
    if (std::isspace(static_cast<unsigned char>(c))) {
      if (!word.empty()) words.push_back(std::move(word));
      word.clear();
    } else {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

/// Numbers of a line, as many as asked for and nothing behind them.
template <std::size_t n>
bool numbers_of(std::string_view line, double (&values)[n]) {
  for (double& value : values) {
    if (!take_number(line, value)) return false;
  }
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

bool is_count(double value, double least) {
  return value >= least && value <= largest_size && value == std::floor(value);
}

}  // namespace

bool take_number(std::string_view& text, double& value) {
  const std::size_t start = text.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return false;
  const char* begin = text.data() + start + (text[start] == '+' ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [after, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || !std::isfinite(value)) return false;
  text.remove_prefix(static_cast<std::size_t>(after - text.data()));
  return true;
}

Eigen::SparseMatrix<double> parse_matrix_market(std::string_view bytes, const std::string& name) {
  Lines lines(bytes, name);
  std::string_view line;
  const std::string allowed =
      "is '%%MatrixMarket matrix coordinate|array real|integer general|symmetric'";
  if (!lines.next_of_any_kind(line)) lines.fail_at_end("nothing is in it");
  const auto header = words_of(line);
  const auto word = [&](std::size_t i, const char* a, const char* b) {
    return header[i] == a || header[i] == b;
  };
  if (header.size() != 5 || header[0] != "%%matrixmarket" || header[1] != "matrix" ||
      !word(2, "coordinate", "array") || !word(3, "real", "integer") ||
      !word(4, "general", "symmetric")) {
    lines.fail(line, allowed);
  }
  const bool coordinate = header[2] == "coordinate", symmetric = header[4] == "symmetric";
  if (!lines.next(line)) lines.fail_at_end("the line with the size of the matrix is missing");
  double size[2], size_and_count[3];
  double n_entries = 0;
  if (coordinate ? numbers_of(line, size_and_count) : numbers_of(line, size)) {
    if (coordinate) {
      std::copy_n(size_and_count, 2, size);
      n_entries = size_and_count[2];
    }
  } else {
    lines.fail(line, coordinate ? "are three counts: rows, columns, entries"
                                : "are two counts: rows, columns");
  }
  if (!is_count(size[0], 1) || !is_count(size[1], 1) || (symmetric && size[0] != size[1])) {
    lines.fail(line, symmetric ? "is a square matrix with at least one row"
                               : "is a matrix with at least one row and column");
  }
  const auto n_rows = static_cast<Index>(size[0]), n_cols = static_cast<Index>(size[1]);
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](Index i, Index j, double value) {
    entries.emplace_back(i, j, value);
    if (symmetric && i != j) entries.emplace_back(j, i, value);
  };
  if (coordinate) {
    for (double k = 0; k < n_entries; ++k) {
      if (!lines.next(line)) {
        lines.fail_at_end(std::to_string(static_cast<long>(n_entries)) + " entries are announced");
      }
      double entry[3];
      if (!numbers_of(line, entry) || !is_count(entry[0], 1) || !is_count(entry[1], 1) ||
          entry[0] > size[0] || entry[1] > size[1]) {
        lines.fail(line, "are row, column and value of an entry");
      }
      if (symmetric && entry[1] > entry[0]) {
        lines.fail(line, "are entries of the lower triangle: the matrix says to be symmetric");
      }
      add(static_cast<Index>(entry[0]) - 1, static_cast<Index>(entry[1]) - 1, entry[2]);
    }
  } else {
    if (size[0] * size[1] > largest_size) lines.fail(line, "is an array that is smaller");
    for (Index j = 0; j < n_cols; ++j) {
      for (Index i = symmetric ? j : 0; i < n_rows; ++i) {
        if (!lines.next(line)) lines.fail_at_end("entries are missing");
        double entry[1];
        if (!numbers_of(line, entry)) lines.fail(line, "is one number a line");
        add(i, j, entry[0]);
      }
    }
  }
  if (lines.next(line)) lines.fail(line, "is nothing behind the last entry");
  Eigen::SparseMatrix<double> matrix(n_rows, n_cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::string matrix_market(const Eigen::MatrixXd& symmetric, const std::string& comment) {
  std::string text = "%%MatrixMarket matrix array real symmetric\n% " + comment + "\n" +
                     std::to_string(symmetric.rows()) + " " + std::to_string(symmetric.cols()) +
                     "\n";
  char digits[32];
  for (Index j = 0; j < symmetric.cols(); ++j) {
    for (Index i = j; i < symmetric.rows(); ++i) {
      std::snprintf(digits, sizeof digits, "%.17g\n", symmetric(i, j));
      text += digits;
    }
  }
  return text;
}

}  // namespace stillframe

#include "plant_sim/floor/recording_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/files/bytes_of_file.hpp"
#include "core/files/utf8.hpp"
#include "core/yaml/reader.hpp"
#include "plant_sim/floor/block_values.hpp"
#include "plant_sim/floor/resample.hpp"

namespace stillframe::floor {

namespace {

constexpr std::string_view time_column = "time_s";
/// Of a text of the file a message shows so many bytes, as of one in YAML.
constexpr std::size_t longest_shown = 80;
/// What is resampled is faded in and out so long.
constexpr double taper_s = 1.0;

struct Cell {
  std::string_view text;
  std::size_t column;  // of the character where it begins, from 1
};

/// The text of the file line by line, and where in it the reading stands.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : path_(path.string()) {
    auto text = bytes_of_file(path);
    if (!text) {
      throw InputError(path_ + ": no such file, or not readable; a recording (CSV) is needed");
    }
    text_ = *std::move(text);
    // With this mark some programs begin every UTF-8.
    if (text_.starts_with("\xEF\xBB\xBF")) begin_ = 3;
  }

  bool next() {
    if (begin_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', begin_), text_.size());
    line_ = std::string_view(text_).substr(begin_, end - begin_);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    begin_ = end + 1;
    ++number_;
    return true;
  }

  std::string_view line() const { return line_; }

  [[noreturn]] void fail(std::size_t column, const std::string& message) const {
    throw InputError(path_ + ":" + std::to_string(std::max<std::size_t>(number_, 1)) + ":" +
                     std::to_string(column) + ": " + message);
  }

 private:
  std::string path_, text_;
  std::string_view line_;
  std::size_t begin_ = 0, number_ = 0;
};

std::vector<Cell> split(std::string_view line, char separator) {
  std::vector<Cell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    std::size_t first = begin, last = end;
    while (first < last && (line[first] == ' ' || line[first] == '\t')) ++first;
    while (last > first && (line[last - 1] == ' ' || line[last - 1] == '\t')) --last;
    cells.push_back({line.substr(first, last - first), first + 1});
    begin = end + 1;
  }
  return cells;
}

std::optional<double> to_finite(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string shown(std::string_view text) { return printable(text, longest_shown); }

std::string quoted(std::string_view text) { return "'" + shown(text) + "'"; }

/// What the comment lines say.
struct Statements {
  std::string wanted_units;
  std::optional<double> fs_hz = std::nullopt, n = std::nullopt;
  bool units = false;
  std::string columns = "";
};

void read_number(const Lines& lines, const Cell& word, std::string_view value,
                 std::optional<double>& out, bool whole, const std::string& allowed) {
  if (out) lines.fail(word.column, quoted(word.text) + " is said twice");
  out = to_finite(value);
  if (!out || !(*out > 0.0) || (whole && (*out > 1e12 || std::floor(*out) != *out))) {
    lines.fail(word.column, "found " + quoted(word.text) + ", allowed is " + allowed);
  }
}

void read_comment(const Lines& lines, Statements& said) {
  for (const Cell& word : split(lines.line(), ' ')) {
    const std::string_view key = word.text.substr(0, word.text.find('='));
    if (key.size() == word.text.size()) continue;
    const std::string_view value = word.text.substr(key.size() + 1);
    if (key == "fs_hz") {
      read_number(lines, word, value, said.fs_hz, false, "fs_hz=RATE, a number above 0");
    } else if (key == "n") {
      read_number(lines, word, value, said.n, true, "n=ROWS, a whole number above 0");
    } else if (key == "units") {
      if (value != said.wanted_units) {
        lines.fail(word.column,
                   "units: found " + quoted(value) + ", allowed is " + said.wanted_units);
      }
      said.units = true;
    } else if (key == "columns") {
      said.columns = value;
    }
  }
}

/// Reads comments and header; the names of all columns are returned.
std::vector<std::string> read_head(Lines& lines, Statements& said) {
  bool more = lines.next();
  for (; more && lines.line().starts_with('#'); more = lines.next()) read_comment(lines, said);
  if (!more) lines.fail(1, "the file is empty: allowed are comments, a header and rows of numbers");
  const auto require = [&](bool present, const std::string& what) {
    if (!present) lines.fail(1, "the comment lines above do not say " + what);
  };
  require(said.fs_hz.has_value(), "fs_hz=RATE (samples per second)");
  require(said.n.has_value(), "n=ROWS (number of samples)");
  require(said.units, "units=" + said.wanted_units);
  std::vector<std::string> names;
  for (const Cell& cell : split(lines.line(), ',')) {
    if (cell.text.empty() || to_finite(cell.text)) {
      lines.fail(cell.column, "header: found " + quoted(cell.text) + ", allowed is a column name");
    }
    if (std::find(names.begin(), names.end(), cell.text) != names.end()) {
      lines.fail(cell.column, "header: " + quoted(cell.text) + " stands twice");
    }
    names.emplace_back(cell.text);
  }
  if (!said.columns.empty() && said.columns != lines.line()) {
    lines.fail(1, "header: found " + quoted(lines.line()) +
                      ", but the comment says columns=" + shown(said.columns));
  }
  return names;
}

double read_cell(const Lines& lines, const Cell& cell, const std::string& name) {
  const auto value = to_finite(cell.text);
  if (!value) {
    lines.fail(cell.column,
               shown(name) + ": found " + quoted(cell.text) + ", allowed is a finite number");
  }
  return *value;
}

/// An instant may be rounded, but not by a tenth of a step: a lost sample shifts it by a whole one.
void check_time(const Lines& lines, const Cell& cell, double time, double first, std::size_t row,
                double fs_hz) {
  const double expected = first + static_cast<double>(row) / fs_hz;
  if (std::abs(time - expected) <= 0.1 / fs_hz) return;
  std::ostringstream message;
  message.precision(12);
  message << time_column << ": found " << time << ", allowed is " << expected
          << " (even steps of 1/fs_hz, no gaps)";
  lines.fail(cell.column, message.str());
}

void read_row(const Lines& lines, const std::vector<std::string>& names, double fs_hz,
              std::size_t row, double& first_time, std::vector<double>& values) {
  const std::vector<Cell> cells = split(lines.line(), ',');
  if (cells.size() != names.size()) {
    const Cell& where = cells[std::min(cells.size() - 1, names.size())];
    lines.fail(where.column, "found " + std::to_string(cells.size()) + " columns, allowed is " +
                                 std::to_string(names.size()) + " as in the header");
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double value = read_cell(lines, cells[i], names[i]);
    if (names[i] != time_column) {
      values.push_back(value);
      continue;
    }
    if (row == 0) first_time = value;
    check_time(lines, cells[i], value, first_time, row, fs_hz);
  }
}

}  // namespace

RecordingFile read_recording(const std::filesystem::path& path, const std::string& units) {
  Lines lines(path);
  Statements said{.wanted_units = units};
  const std::vector<std::string> names = read_head(lines, said);

  RecordingFile result;
  result.sample_rate_hz = *said.fs_hz;
  for (const auto& name : names) {
    if (name != time_column) result.columns.push_back(name);
  }
  if (result.columns.empty()) lines.fail(1, "header: allowed is at least one axis beside time_s");

  std::vector<double> values;
  std::size_t row = 0;
  for (double first_time = 0.0; lines.next(); ++row) {
    read_row(lines, names, result.sample_rate_hz, row, first_time, values);
  }
  if (row == 0) lines.fail(1, "no rows of numbers follow the header");
  if (static_cast<double>(row) != *said.n) {
    lines.fail(1, "the rows end here after " + std::to_string(row) + ", but the comment says n=" +
                      std::to_string(static_cast<std::int64_t>(*said.n)) +
                      ": samples are missing or too many");
  }
  result.acceleration = Eigen::Map<const Eigen::MatrixXd>(
      values.data(), static_cast<Eigen::Index>(result.columns.size()),
      static_cast<Eigen::Index>(row));
  return result;
}

Eigen::MatrixXd play_recording(const RecordingPart& part, double rate,
                               const RecordingErrors& errors) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(part.file, ignored)) {
    errors.file("found '" + part.file.string() + "', which is missing or no file");
  }
  const RecordingFile recording = read_recording(part.file, part.units);
  const double fs = recording.sample_rate_hz;
  const auto ratio = rational_ratio(fs, rate);
  if (!ratio) {
    errors.file("found a recording at " + text_of(fs) +
                " Hz, allowed is a rate whose ratio to the control rate of " + text_of(rate) +
                " Hz is one of whole numbers up to 10000");
  }
  const auto taper = static_cast<Eigen::Index>(std::ceil(taper_s * fs));
  const double n = static_cast<double>(recording.acceleration.cols());
  const double left = n - std::round(part.start_s * fs);
  if (left <= 2.0 * static_cast<double>(taper)) {
    errors.start("found " + text_of(n / fs - part.start_s) + " s of " + part.file.string() +
                 " from start_s on, allowed is more than 2 s");
  }
  const auto& names = recording.columns;
  Eigen::MatrixXd piece(static_cast<Eigen::Index>(part.columns.size()),
                        static_cast<Eigen::Index>(left));
  for (std::size_t i = 0; i < part.columns.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), part.columns[i]);
    if (found == names.end()) {
      const auto join = [](const std::string& list, const std::string& name) {
        return list.empty() ? name : list + ", " + name;
      };
      const std::string near = nearest_name(part.columns[i], names);
      errors.column(
          i, quoted(std::string_view(part.columns[i])) + " is no column of " + part.file.string() +
                 (near.empty() ? "" : " (did you mean '" + near + "'?)") +
                 "; allowed: " + std::accumulate(names.begin(), names.end(), std::string(), join));
    }
    piece.row(static_cast<Eigen::Index>(i)) =
        part.scale * recording.acceleration.row(found - names.begin()).tail(piece.cols());
  }
  taper_ends(piece, taper);
  return resample(piece, *ratio);
}

}  // namespace stillframe::floor

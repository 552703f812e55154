#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/json.hpp"

namespace stillframe::tools {

/// What a study writes, a line of JSON a row, in a file that `--out` names.
struct RowKind {
  std::string verb;
  std::vector<std::string> identity;  ///< keys that tell which row it is, and of what
  std::vector<std::string> others;    ///< keys that every row has besides
};

/// A file of rows that grows by whole lines, in which what is there already need not be computed
/// again. Lines of any such files may be put together in any order.
class RowFile {
 public:
  /// Reads it, if it is there. A line without an end, of a program that was killed, does not count,
  /// and is taken off before the file grows if it is the last. Errors: InputError of a file that
  /// cannot be read, that is none of these, or of which a row was changed.
  RowFile(std::filesystem::path path, const RowKind& kind);

  /// The row of this identity, or null. Of one that was computed twice it is the last.
  const Json* find(const Json& row) const;
  /// Lines without an end: the last one, and those that another program wrote on after.
  std::size_t n_unfinished() const { return n_broken_ + (unfinished_ > 0 ? 1 : 0); }
  /// Whether a file is empty, or has nothing but a line without an end.
  static bool is_half_a_row(const std::filesystem::path& path);
  /// By the text of their identity.
  const std::map<std::string, Json>& rows() const { return rows_; }
  /// Errors: OutputError where the file does not grow, or has lost what was in it; half a line is
  /// taken off again.
  void add(const Json& row);

 private:
  std::string key_of(const Json& row) const;

  std::filesystem::path path_;
  RowKind kind_;
  std::size_t unfinished_ = 0;  ///< bytes of the last line, if it has no end
  std::size_t n_broken_ = 0;    ///< lines that begin as a row and do not end as one
  std::uintmax_t size_ = 0;     ///< bytes that were in it, at least
  std::map<std::string, Json> rows_;
};

/// Whether a row is of this kind.
bool is_row(const Json& row, const RowKind& kind);

/// A row as a line with its end, and with a check of it, by which what was changed since is known;
/// names and reasons may be bytes that are no UTF-8.
std::string line_of(const Json& row);

/// A study, point by point.
struct RowStudy {
  const char* things;  ///< what its points are called while one waits
  std::size_t n_points;
  /// Row i as far as the keys of its identity, null where they cannot be told.
  std::function<Json(std::size_t i)> identity;
  /// Whether a row of that identity answers what is asked for.
  std::function<bool(const Json& row)> answers;
  /// Row i, whatever comes of it.
  std::function<Json(std::size_t i)> compute;
};

/// The points at these places, in order: as the file has them, if there is one, or computed side by
/// side and added to it. jobs: 0 for each core one. Errors: Failure when interrupted.
std::vector<Json> fill_rows(const RowStudy& study, const std::vector<std::size_t>& points, int jobs,
                            RowFile* file);

}  // namespace stillframe::tools

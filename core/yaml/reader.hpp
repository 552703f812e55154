#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/errors/input_error.hpp"

namespace YAML {
class Node;
}

namespace stillframe {

/// Beyond what any quantity in SI units is. Products and quotients of several such numbers, and
/// the squares of those, still are numbers: nothing a model is computed from overflows.
inline constexpr double largest_number = 1e30, smallest_number = 1e-30;

/// A number as messages show it: the fewest digits that give it back, the same under every locale.
std::string shortest_digits(double value);

/// One value of a YAML file that knows where it stands and how it is called, so that every error
/// can say so. All functions throw InputError "file:line:column: key: found ..., allowed ...".
class YamlReader {
 public:
  /// Reads a file, once, and parses it. Errors: a missing or unreadable file, and those of
  /// from_text.
  static YamlReader from_file(const std::filesystem::path& path);
  /// Parses text, and writes out what it says by shorthand; source_name stands for the file in
  /// messages, folder for its folder. Errors: bytes that are no UTF-8, YAML syntax, a duplicate
  /// key, and those of write_out.
  static YamlReader from_text(const std::string& text, const std::string& source_name,
                              const std::filesystem::path& folder = {});

  /// All of the text that this value is a part of, with its shorthand as it stands there.
  YamlReader as_written() const;

  /// The value of a key of this map; `require` fails if the key is absent, `find` answers nothing.
  YamlReader require(const std::string& key) const;
  std::optional<YamlReader> find(const std::string& key) const;
  /// Fails on the first key of this map that is not in the list, naming the nearest one that is.
  void allow_only(const std::vector<std::string_view>& keys) const;

  bool is_map() const;
  bool is_sequence() const;
  bool is_scalar() const;
  /// The entries of this map, or the items of this sequence, in the order of the file.
  std::vector<std::pair<std::string, YamlReader>> entries() const;
  std::vector<YamlReader> items() const;

  /// Scalars. number() takes finite numbers up to a size; positive() and non_negative() besides ask
  /// for what is not smaller than smallest_number, or is 0; integer() takes whole numbers from
  /// lowest up.
  double number(double largest = largest_number) const;
  double positive() const;
  double non_negative() const;
  std::int64_t integer(std::int64_t lowest) const;
  bool boolean() const;
  std::string text() const;
  /// A scalar that is one of the given words.
  std::string one_of(std::initializer_list<std::string_view> words) const;

  /// A sequence of `size` numbers (any number of them if size is negative), and a matrix as a
  /// sequence of rows.
  Eigen::VectorXd vector(Eigen::Index size = -1, double largest = largest_number) const;
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index cols,
                         double largest = largest_number) const;

  /// The file whose path stands here, from the folder of this one: its name and its bytes, `most`
  /// at most. Errors: InputError of a file that is missing, empty, a folder or larger.
  std::pair<std::filesystem::path, std::string> file_bytes(std::size_t most) const;

  /// Throws InputError "place: key: message".
  [[noreturn]] void fail(const std::string& message) const;
  /// "file:line:column".
  std::string place() const;
  /// How the value is called, as in "elements.leg_1.stiffness".
  const std::string& name() const { return name_; }
  /// This value as YAML text.
  std::string dump() const;
  /// Folder of the file, against which paths inside it are resolved; empty for text.
  std::filesystem::path folder() const;
  /// All of the text that this value is a part of, byte for byte.
  const std::string& source_text() const;
  /// The same with another text in the place of this scalar, which stands there as it reads, plain
  /// or in quotes; as it is if the scalar is written in another way, with escapes, over lines or by
  /// shorthand.
  std::string source_text_with(const std::string& text) const;

 private:
  struct Source;
  YamlReader(std::shared_ptr<const Source> source, const YAML::Node& node, std::string name);
  [[noreturn]] void fail_found(const std::string& allowed) const;

  std::shared_ptr<const Source> source_;
  std::shared_ptr<const YAML::Node> node_;
  std::string name_;
};

/// The candidate with the smallest edit distance to `word`, or an empty string if none is near.
std::string nearest_name(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace stillframe

// What CalculiX writes: matrices without a header, and a deck of keywords.
#include <algorithm>
#include <charconv>
#include <fstream>
#include <set>
#include <sstream>

#include "core/errors/input_error.hpp"
#include "core/files/matrix_market.hpp"
#include "core/files/utf8.hpp"
#include "core/mechanics/bodies/finite_element_body.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

namespace {

using Eigen::Index;
namespace fs = std::filesystem;

/// The lines of a file, with their numbers for messages.
class TextLines {
 public:
  explicit TextLines(const fs::path& file) : file_(file), stream_(file, std::ios::binary) {
    if (!stream_ || fs::is_directory(file)) {
      throw InputError(file.string() + ": cannot be read (missing, a folder or not allowed)");
    }
  }
  bool next(std::string& line) {
    if (!std::getline(stream_, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    ++number_;
    return true;
  }
  [[noreturn]] void fail(const std::string& line, const std::string& allowed) const {
    throw InputError(file_.string() + ":" + std::to_string(number_) + ": found '" +
                     printable(line, 60) + "', allowed " + allowed);
  }
  const fs::path& file() const { return file_; }

 private:
  fs::path file_;
  std::ifstream stream_;
  long number_ = 0;
};

bool whole(std::string_view& text, long& value) {
  double number = 0;
  if (!take_number(text, number) || number != static_cast<double>(static_cast<long>(number))) {
    return false;
  }
  value = static_cast<long>(number);
  return true;
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(" \t") == std::string_view::npos;
}

std::string capitals(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> parts;
  std::stringstream stream(line);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(trimmed(part));
  return parts;
}

/// Nodes and sets of a deck; everything else is passed over.
class Deck {
 public:
  explicit Deck(FiniteElementBody& body) : body_(body) {}

  void read(const fs::path& file, int depth = 0) {
    TextLines lines(file);
    for (std::string line; lines.next(line);) {
      if (line.starts_with("**") || is_blank(line)) continue;
      if (line.starts_with("*")) {
        keyword(line, lines, depth);
      } else if (kind_ == Kind::nodes) {
        node(line, lines);
      } else if (kind_ == Kind::set) {
        members(line, lines);
      }
    }
    kind_ = Kind::other;
  }

 private:
  enum class Kind { other, nodes, set };

  void keyword(const std::string& line, const TextLines& lines, int depth) {
    const auto words = fields(line);
    const std::string name = capitals(words[0]);
    kind_ = name == "*NODE" ? Kind::nodes : name == "*NSET" ? Kind::set : Kind::other;
    set_.clear();
    generate_ = false;
    std::string include;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto equals = words[i].find('=');
      const std::string key = capitals(trimmed(words[i].substr(0, equals)));
      const std::string value =
          equals == std::string::npos ? "" : trimmed(words[i].substr(equals + 1));
      if (key == "NSET") set_ = capitals(value);
      if (key == "GENERATE") generate_ = true;
      if (key == "INPUT") include = value;
    }
    if (kind_ == Kind::set && set_.empty()) lines.fail(line, "is *NSET, NSET=name");
    if (name != "*INCLUDE") return;
    if (include.empty()) lines.fail(line, "is *INCLUDE, INPUT=file");
    if (depth > 20) lines.fail(line, "are 20 files that include each other");
    std::erase(include, '"');
    read(lines.file().parent_path() / include, depth + 1);
  }

  void node(const std::string& line, const TextLines& lines) {
    const auto parts = fields(line);
    long number = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    const std::string allowed = "is number, x, y, z of a node";
    if (parts.size() < 2 || parts.size() > 4) lines.fail(line, allowed);
    std::string_view text = parts[0];
    if (!whole(text, number) || !is_blank(text)) lines.fail(line, allowed);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      std::string_view coordinate = parts[i];
      if (!take_number(coordinate, position(static_cast<Index>(i) - 1)) || !is_blank(coordinate)) {
        lines.fail(line, allowed);
      }
    }
    body_.nodes[number] = position;
    if (!set_.empty()) body_.sets[set_].push_back(number);
  }

  void members(const std::string& line, const TextLines& lines) {
    std::vector<long> numbers;
    for (const std::string& part : fields(line)) {
      if (part.empty()) continue;
      std::string_view text = part;
      long number = 0;
      if (whole(text, number) && is_blank(text)) {
        numbers.push_back(number);
        continue;
      }
      const auto other = body_.sets.find(capitals(part));
      if (generate_ || other == body_.sets.end()) {
        lines.fail(line, "are numbers of nodes or names of sets that stand above");
      }
      const std::vector<long> copy = other->second;
      auto& set = body_.sets[set_];
      set.insert(set.end(), copy.begin(), copy.end());
    }
    auto& set = body_.sets[set_];
    if (!generate_) {
      set.insert(set.end(), numbers.begin(), numbers.end());
      return;
    }
    if (numbers.size() == 2) numbers.push_back(1);
    if (numbers.size() != 3 || numbers[2] < 1 || numbers[1] < numbers[0]) {
      lines.fail(line, "are first, last and step of what is generated");
    }
    for (long i = numbers[0]; i <= numbers[1]; i += numbers[2]) set.push_back(i);
  }

  FiniteElementBody& body_;
  Kind kind_ = Kind::other;
  std::string set_;
  bool generate_ = false;
};

/// "node.direction" a line; answers how many there are.
Index read_dofs(const fs::path& file, FiniteElementBody& body) {
  TextLines lines(file);
  Index n = 0;
  for (std::string line; lines.next(line);) {
    if (is_blank(line)) continue;
    const std::string text = trimmed(line);
    const auto point = text.find('.');
    long node = 0;
    const char* const end = text.data() + std::min(point, text.size());
    const auto [after, error] = std::from_chars(text.data(), end, node);
    if (point == std::string::npos || error != std::errc() || after != end ||
        point + 2 != text.size()) {
      lines.fail(line, "is node.direction");
    }
    const char direction = text.back();
    if (direction < '1' || direction > '3') {
      lines.fail(line, "are directions 1 to 3: a body of solid elements");
    }
    if (!body.nodes.contains(node)) {
      lines.fail(
          line,
          "are nodes of the deck (of shells, beams and C3D8I CalculiX makes nodes of its own: "
          "mesh the body with solids)");
    }
    auto& rows = body.rows.try_emplace(node, std::array<Index, 3>{-1, -1, -1}).first->second;
    auto& row = rows[static_cast<std::size_t>(direction - '1')];
    if (row >= 0) lines.fail(line, "is each degree of freedom once");
    row = n++;
  }
  if (n == 0) throw InputError(file.string() + ": has no degrees of freedom");
  return n;
}

Eigen::SparseMatrix<double> read_triangle(const fs::path& file, Index n) {
  TextLines lines(file);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::string line; lines.next(line);) {
    if (is_blank(line)) continue;
    std::string_view text = line;
    long i = 0, j = 0;
    double value = 0;
    if (!whole(text, i) || !whole(text, j) || !take_number(text, value) || !is_blank(text) ||
        i < 1 || j < 1 || i > n || j > n) {
      lines.fail(line, "are row, column (1 to " + std::to_string(n) + ") and a number");
    }
    entries.emplace_back(i - 1, j - 1, value);
    if (i != j) entries.emplace_back(j - 1, i - 1, value);
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

FiniteElementBody read_calculix(const fs::path& job,
                                const std::function<void(const std::string&)>& stage) {
  const auto file = [&](const char* extension) {
    fs::path path = job;
    if (path.extension() == ".inp") path.replace_extension();
    return path += extension;
  };
  FiniteElementBody body;
  body.name = file("").string();
  stage("reading the mesh");
  Deck(body).read(file(".inp"));
  const Index n = read_dofs(file(".dof"), body);
  stage("reading the matrices");
  body.K = read_triangle(file(".sti"), n);
  body.M = read_triangle(file(".mas"), n);
  return body;
}

const std::vector<long>& node_set(const FiniteElementBody& body, const std::string& name,
                                  const std::string& place) {
  const auto found = body.sets.find(capitals(name));
  if (found != body.sets.end() && !found->second.empty()) return found->second;
  std::vector<std::string> names;
  for (const auto& [each, nodes] : body.sets) names.push_back(each);
  const std::string near = nearest_name(capitals(name), names);
  throw InputError(place + ": there is no set of nodes named '" + name + "' in the mesh" +
                   (near.empty() ? "" : "; the nearest name is '" + near + "'"));
}

}  // namespace stillframe

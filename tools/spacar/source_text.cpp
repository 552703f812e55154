#include "tools/spacar/source_text.hpp"

#include <algorithm>

#include "core/files/bytes_of_file.hpp"
#include "tools/spacar/place.hpp"

namespace stillframe::tools::spacar {

namespace {

constexpr std::size_t most_bytes = 16u << 20u, longest_line = 10000;

std::string bytes_of(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw InputError(path.string() + ": is a folder, allowed is a file");
  }
  auto bytes = bytes_of_file(path, most_bytes);
  if (!bytes) throw InputError(path.string() + ": cannot be read");
  if (bytes->size() > most_bytes) {
    throw InputError(path.string() + ": found more than 16 MiB, allowed are 16 MiB");
  }
  return *std::move(bytes);
}

}  // namespace

std::vector<std::string> lines_of_file(const std::filesystem::path& path) {
  const std::string bytes = bytes_of(path), name = path.string();
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find_first_of("\r\n", begin), bytes.size());
    lines.push_back(bytes.substr(begin, end - begin));
    const int number = static_cast<int>(lines.size());
    if (lines.back().size() > longest_line) {
      refuse(name, number, "line", std::to_string(lines.back().size()) + " bytes",
             std::to_string(longest_line) + " at most");
    }
    const bool control = std::any_of(lines.back().begin(), lines.back().end(), [](char c) {
      return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\f';
    });
    if (control) refuse(name, number, "line", "a control character", "are those of a text");
    begin = end + 1;
    if (end + 1 < bytes.size() && bytes[end] == '\r' && bytes[end + 1] == '\n') ++begin;
  }
  const bool empty = std::all_of(lines.begin(), lines.end(), [](const std::string& line) {
    return line.find_first_not_of(" \t\f") == std::string::npos;
  });
  if (empty) throw InputError(name + ": is empty");
  return lines;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::string shown(std::string_view text) {
  std::string out(text.substr(0, 40));
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text.size() > 40 ? out + "..." : out;
}

}  // namespace stillframe::tools::spacar

#include "core/files/bytes_of_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace stillframe {

std::optional<std::string> bytes_of_file(const std::filesystem::path& path, std::size_t most) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::string bytes;
  for (std::vector<char> part(std::size_t{1} << 16); file && bytes.size() <= most;) {
    file.read(part.data(), static_cast<std::streamsize>(part.size()));
    bytes.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return std::nullopt;
  if (bytes.size() > most) bytes.resize(most + 1);
  return bytes;
}

std::string why_no_bytes(const std::filesystem::path& path) {
  return access(path.c_str(), R_OK) == 0 ? "it is empty" : std::strerror(errno);
}

}  // namespace stillframe

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace stillframe {

/// All of a file, a pipe or a device; one byte more than `most` where there is more than that, so
/// that a device without an end can be refused as well. None if it is a folder or cannot be read.
std::optional<std::string> bytes_of_file(const std::filesystem::path& path,
                                         std::size_t most = std::string::npos);

/// Why it gave none, or no more than none: the system's words, or "it is empty".
std::string why_no_bytes(const std::filesystem::path& path);

}  // namespace stillframe

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace stillframe::tools::spacar {

/// The lines of a text file, without what ends them (LF, CR LF or CR); numbered from 1, so that
/// line n is [n - 1]. Errors: InputError of a file that cannot be read, is empty, has more than 16
/// MiB, a line of more than 10000 bytes, or bytes that no text has.
std::vector<std::string> lines_of_file(const std::filesystem::path& path);

/// In small letters, of ASCII alone.
std::string lower(std::string_view text);

/// A piece of what a person wrote, for a message: printable, forty characters at most.
std::string shown(std::string_view text);

}  // namespace stillframe::tools::spacar

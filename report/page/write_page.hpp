#pragma once

#include <filesystem>
#include <string>

#include "report/page/page_data.hpp"

namespace stillframe::page {

/// The page as one HTML text that needs nothing beside it: styles, scripts and data are in it, and
/// its content security policy lets it load nothing. Every text from outside is escaped. Errors:
/// InputError for data whose sizes do not fit each other, naming the part. Set-up.
std::string page_text(const PageData& data);

/// Writes page_text() as a WholeFile. Errors: those above and those of WholeFile.
void write_page(const PageData& data, const std::filesystem::path& path);

/// Most bytes that all time histories take in the page; finer ones are halved until they fit, so
/// that a run of any length makes a page below 3 MB.
inline constexpr std::size_t most_history_bytes = 1'100'000;

}  // namespace stillframe::page

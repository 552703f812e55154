#pragma once

#include <filesystem>

namespace stillframe::fuzz {

/// Writes one sound message of every type into folder/messages and a short sound log into
/// folder/log: made, not kept, so that they follow the types of msgs/.
void write_seeds(const std::filesystem::path& folder);

}  // namespace stillframe::fuzz

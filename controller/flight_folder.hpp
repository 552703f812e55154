#pragma once

#include <cstdint>
#include <filesystem>

namespace stillframe::controller {

/// How much a folder of flight records may hold.
struct FlightBounds {
  std::int64_t files = 0;
  double bytes = 0;
};

/// The name after the last of a run: flight-RUN-N.lcm. Set-up. Errors: std::filesystem_error.
std::filesystem::path next_flight_file(const std::filesystem::path& folder, std::int64_t run_id);

/// Removes the oldest flight records until the folder is within its bounds, but never the newest
/// one; and what controllers that are no more left unfinished. Touches nothing else. Set-up.
/// Errors: std::filesystem_error.
void make_room(const std::filesystem::path& folder, const FlightBounds& bounds);

}  // namespace stillframe::controller

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "report/analysis/loop_response.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::judge {

/// When a loop by the clock held its frame with its whole command, which was passive before.
struct Hold {
  report::Takeover takeover;
  bool ever = false;  ///< takeover.full is a sample of that time, and no guess
  /// The first sample that it did not hold any more. It goes on holding in a fade that it comes
  /// back from without a fault.
  std::int64_t until = report::Takeover::never;
  bool fault = false;  ///< why it let go, or, if it never held, what its controller had before
  std::string why;     ///< it never held, or let go; empty: it held to the end

  /// Of a loop that held: the samples that it did, from the first to the one behind the last.
  std::int64_t from() const { return takeover.full; }
};

/// Of an active run by the clock, by the records of its controller; none of other runs. Later
/// times, after it let go and took hold again, are not looked for. The log is read to its end, of
/// measurements only their heads. Errors: InputError if it cannot be read or has no record.
std::optional<Hold> hold_of(const std::filesystem::path& log,
                            const stillframe_msgs::run_info_t& info);

}  // namespace stillframe::judge

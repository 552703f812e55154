#pragma once

#include <string>

#include "report/live/live_view.hpp"

namespace stillframe::live {

/// A view as one line of JSON without a line break at its end; docs/live.md has its keys. Numbers
/// read back to the same bits, one that is not finite is null. with_history adds
/// the key history, and makes run_id a text.
std::string to_json(const LiveView& view, bool with_history);

}  // namespace stillframe::live

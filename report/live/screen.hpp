#pragma once

#include <string>

#include "report/live/live_view.hpp"

namespace stillframe::live {

/// Room for a view, in characters; a height of 0 is any.
struct ScreenSize {
  int width = 80, height = 0;
};

/// A view as lines of text that are no longer than the width, each with a line break. What does not
/// fit into the height is left out from below, the notes first of all being on top. colours: with
/// ANSI colours. Names from the bus cannot bring control characters onto the terminal.
std::string to_text(const LiveView& view, ScreenSize size, bool colours);

}  // namespace stillframe::live

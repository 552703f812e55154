#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stillframe::report {

// Okabe and Ito's palette, which readers with any colour vision tell apart.
inline constexpr const char* passive_colour = "'#D55E00'";
inline constexpr const char* active_colour = "'#0072B2'";
inline constexpr const char* floor_colour = "'#6E6E6E'";

/// Borders, tics, grid and legend that all pictures share; the place of the legend is left to them.
std::string frame_style();

/// Of a picture, a panel an axis.
inline constexpr std::size_t most_panels = 6;

/// The edges of a panel as fractions of the picture.
std::string margins(double left, double right, double bottom, double top);

/// A logarithmic frequency axis, Hz, with the steps labelled that a reader looks for; empty titles
/// are left out.
std::string frequency_axis(double lowest_hz, double highest_hz, const std::string& title);

/// What belongs to a picture of several panels and to no panel.
struct Surroundings {
  std::string title;                ///< above all panels
  std::string left_label;           ///< along the left edge
  std::vector<std::string> legend;  ///< below them: keyentry commands
};

/// A line of a legend: `style` as behind a plot command.
std::string legend_entry(const std::string& style, const std::string& title);

/// Begins a picture of several panels, its surroundings drawn as a panel of their own without axes.
std::string surround(const Surroundings& around);

/// Parts of a plot command, one a line.
std::string joined(const std::vector<std::string>& parts);

/// Errors: std::invalid_argument "plots: what" unless holds.
void require(bool holds, const std::string& what);

}  // namespace stillframe::report

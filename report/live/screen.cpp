#include "report/live/screen.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/live/styled_text.hpp"
#include "report/spectra/vibration_criteria.hpp"
#include "report/table.hpp"

namespace stillframe::live {

namespace {

using report::count;

std::string significant(double value) { return formatted("%.4g", value); }

Style style_of_state(const std::string& state) {
  if (state == "active") return Style::good;
  return state == "fault" ? Style::bad : Style::warning;
}

/// Whether zero is the good number.
Style style_of_count(std::int64_t n) { return n == 0 ? Style::plain : Style::warning; }

class Screen {
 public:
  Screen(const LiveView& view, int width) : view_(view), width_(width) {}

  StyledText make() {
    head();
    notes();
    if (view_.run) {
      plant();
      controller();
      timing();
      if (!view_.axes.empty()) levels();
      if (!view_.legs.empty()) legs();
    }
    if (!view_.channels.empty()) channels();
    return std::move(text_);
  }

 private:
  void line(const std::string& text, Style style = Style::plain) {
    text_.add(text, style).end_line();
  }
  void label(const std::string& text) { text_.add(padded(text, 12), Style::faint); }

  void head() {
    std::string title = "stillframe watch";
    if (!view_.run) {
      line(title, Style::title);
      return;
    }
    const RunView& run = *view_.run;
    if (!run.scene.empty()) title += "   " + run.scene;
    text_.add(title, Style::title);
    std::string about = "   run " + std::to_string(run.run_id);
    if (!run.loop.empty()) about += ", " + run.loop;
    if (!run.mode.empty()) about += ", " + run.mode;
    if (run.sample_rate_hz > 0) about += ", " + significant(run.sample_rate_hz) + " Hz";
    text_.add(about, Style::faint).end_line();
  }

  void notes() {
    for (const std::string& note : view_.notes) wrapped("! " + note, Style::warning);
  }

  void wrapped(std::string text, Style style) {
    while (width_of(text) > width_) {
      std::size_t cut = text.rfind(' ', static_cast<std::size_t>(width_));
      if (cut == std::string::npos || cut < 3) cut = static_cast<std::size_t>(width_);
      line(text.substr(0, cut), style);
      text = "  " + text.substr(text.find_first_not_of(' ', cut) == std::string::npos
                                    ? text.size()
                                    : text.find_first_not_of(' ', cut));
    }
    line(text, style);
  }

  void plant() {
    const RunView& run = *view_.run;
    label("plant");
    const bool quiet = run.quiet_s > 1;
    const std::string state = !run.state.empty() ? run.state : quiet ? "quiet" : "measuring";
    text_.add(state, quiet ? Style::warning : Style::good);
    if (run.seq < 0) {
      text_.end_line();
      return;
    }
    text_.add(formatted(", %.1f s", run.time_s));
    if (run.duration_s) text_.add(formatted(" of %.1f s", *run.duration_s));
    if (view_.n_missed > 0) {
      text_.add(formatted(", %lld not seen here", count(view_.n_missed)), Style::warning);
    }
    text_.end_line();
  }

  void controller() {
    if (!view_.controller) {
      if (view_.run->mode == "lock_step") {
        label("controller");
        line("says nothing of itself in lock-step", Style::faint);
      }
      return;
    }
    const ControllerView& c = *view_.controller;
    label("controller");
    text_.add(c.text.empty() ? c.state : c.text, style_of_state(c.state));
    if (c.fault != "none" && c.state != "fault") text_.add(", last fault " + c.fault);
    if (c.latched) text_.add(", latched", Style::bad);
    text_.end_line();
    label("periods");
    text_.add(formatted("%lld: ", count(c.n_periods)));
    text_.add(formatted("%lld late", count(c.n_late)), style_of_count(c.n_late));
    text_.add(formatted(", %lld lost", count(c.n_lost)), style_of_count(c.n_lost));
    text_.add(formatted(", %lld without a measurement", count(c.n_missing)),
              style_of_count(c.n_missing));
    text_.add(formatted(", %lld limited", count(c.n_saturated)), style_of_count(c.n_saturated));
    text_.end_line();
    label("faults");
    text_.add(formatted("%lld, %lld rejoined, %lld messages dropped", count(c.n_faults),
                        count(c.n_rejoins), count(c.n_dropped)),
              style_of_count(c.n_faults + c.n_dropped));
    text_.end_line();
    label("worst");
    text_.add(
        formatted("wake-up %.1f us, compute %.1f us", c.worst_wake_up_us, c.worst_compute_us));
    if (c.recent_wake_up_us) {
      text_.add(
          formatted("; last 10 s %.1f us, %.1f us", *c.recent_wake_up_us, *c.recent_compute_us));
    }
    text_.end_line();
  }

  void timing() {
    for (const EndView& t : view_.timing) {
      label(t.source);
      line(formatted(
          "in the end: %lld periods, %lld late, %lld lost, worst wake-up %.1f us, compute "
          "%.1f us",
          count(t.n_periods), count(t.n_late), count(t.n_lost), t.worst_wake_up_us,
          t.worst_compute_us));
    }
  }

  /// Where a velocity stands on a logarithmic scale from a tenth of VC-G to twice VC-A.
  static int place(double velocity, int width) {
    const auto& criteria = report::vibration_criteria();
    const double lowest = std::log10(criteria.back().velocity / 10);
    const double highest = std::log10(criteria.front().velocity * 2);
    const double part = (std::log10(std::max(velocity, 1e-30)) - lowest) / (highest - lowest);
    return std::clamp(static_cast<int>(std::lround(part * width)), 0, width);
  }

  /// A mark for each criterion, or its letter.
  static std::string scale(int width, bool letters) {
    std::string text(static_cast<std::size_t>(width), ' ');
    for (const auto& criterion : report::vibration_criteria()) {
      const auto at = static_cast<std::size_t>(place(criterion.velocity, width));
      if (at < text.size()) text[at] = letters ? criterion.name.back() : '|';
    }
    return text;
  }

  static std::string bar(double velocity, int width) {
    std::string text = scale(width, false);
    if (std::isfinite(velocity)) std::fill_n(text.begin(), place(velocity, width), '=');
    return text;
  }

  void levels() {
    std::size_t longest = 4;
    for (const AxisView& axis : view_.axes) longest = std::max(longest, axis.axis.size());
    const int name = static_cast<int>(std::min<std::size_t>(longest, 16)) + 2;
    const int fixed = name + 7 + 4 * 10 + 12;
    const int bar_width = width_ - fixed - 2 >= 16 ? std::min(width_ - fixed - 2, 48) : 0;
    text_.end_line();
    text_.add(padded("axis", name) + padded("", 7) + padded("rms mm/s^2", 10, false) +
                  padded("peak", 10, false) + padded("band um/s", 10, false) +
                  padded("at Hz", 10, false) + padded("class", 12, false),
              Style::faint);
    if (bar_width > 0) text_.add("  " + scale(bar_width, true), Style::faint);
    text_.end_line();
    for (const AxisView& axis : view_.axes) {
      if (axis.floor) signal(axis.axis, "floor", *axis.floor, name, bar_width);
      signal(axis.floor ? "" : axis.axis, axis.floor ? "frame" : "", axis.frame, name, bar_width);
      if (axis.floor) ratio(axis, name);
    }
    line(formatted("over the last %.1f s", view_.window_s) +
             (view_.window_s < RunSamples::window_s - 0.01
                  ? formatted(" (%.0f s when there are so many)", RunSamples::window_s)
                  : ""),
         Style::faint);
  }

  void signal(const std::string& axis, const std::string& which, const SignalView& signal, int name,
              int bar_width) {
    const report::MotionLevel& level = signal.level;
    text_.add(padded(axis, name) + padded(which, 7) +
              padded(significant(1e3 * level.rms_acceleration), 10, false) +
              padded(significant(1e3 * signal.level.peak_acceleration), 10, false) +
              padded(significant(1e6 * level.largest_band_velocity), 10, false) +
              padded(significant(level.largest_band_hz), 10, false));
    const bool met = level.vibration_class.starts_with("VC");
    text_.add(padded(level.vibration_class, 12, false), met ? Style::good : Style::warning);
    if (bar_width > 0) {
      text_.add("  " + bar(level.largest_band_velocity, bar_width),
                which == "floor" ? Style::faint : Style::plain);
    }
    text_.end_line();
  }

  void ratio(const AxisView& axis, int name) {
    const auto over = [](double a, double b) {
      return b > 0 ? formatted("%.4f", a / b) : std::string("-");
    };
    line(padded("", name) + padded("ratio", 7) +
             padded(over(axis.frame.level.rms_acceleration, axis.floor->level.rms_acceleration), 10,
                    false) +
             padded(over(axis.frame.level.peak_acceleration, axis.floor->level.peak_acceleration),
                    10, false) +
             padded(over(axis.frame.level.largest_band_velocity,
                         axis.floor->level.largest_band_velocity),
                    10, false),
         Style::faint);
  }

  void legs() {
    text_.end_line();
    line(padded("leg", 14) + padded("rms N", 10, false) + padded("peak N", 10, false) +
             padded("of limit", 10, false),
         Style::faint);
    for (const LegView& leg : view_.legs) {
      text_.add(padded(leg.leg, 14) + padded(significant(leg.rms), 10, false) +
                padded(significant(leg.peak), 10, false));
      if (leg.share) {
        text_.add(padded(formatted("%.1f %%", 100 * *leg.share), 10, false),
                  *leg.share > 0.9 ? Style::warning : Style::plain);
      }
      text_.end_line();
    }
  }

  void channels() {
    text_.end_line();
    line(padded("channel", 18) + padded("per s", 10, false) + padded("messages", 12, false) +
             padded("bad", 8, false) + padded("other run", 11, false) + padded("quiet", 10, false),
         Style::faint);
    for (const ChannelView& c : view_.channels) {
      const std::int64_t bad = c.n_broken + c.n_other_version + c.n_wrong_size;
      text_.add(padded(c.name, 18) + padded(formatted("%.1f", c.per_s), 10, false) +
                padded(formatted("%lld", count(c.n)), 12, false));
      text_.add(padded(formatted("%lld", count(bad)), 8, false), style_of_count(bad));
      text_.add(padded(formatted("%lld", count(c.n_other_run)), 11, false));
      text_.add(padded(c.quiet_s > 1 ? formatted("%.0f s", c.quiet_s) : "", 10, false),
                Style::faint);
      text_.end_line();
    }
  }

  const LiveView& view_;
  int width_;
  StyledText text_;
};

}  // namespace

std::string to_text(const LiveView& view, ScreenSize size, bool colours) {
  const int width = std::max(size.width, 20);
  return Screen(view, width).make().print(width, size.height, colours);
}

}  // namespace stillframe::live

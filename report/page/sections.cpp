#include "report/page/sections.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>

#include "report/page/html.hpp"
#include "report/page/tables.hpp"

namespace stillframe::page {

namespace {

/// An empty place for a chart of a height in CSS pixels, with what it shows in words.
std::string chart(const std::string& id, const std::string& words, int height,
                  const std::string& title = "", const std::string& caption = "",
                  const std::string& paper_share = "") {
  return element("figure", {},
                 (title.empty() ? "" : text_element("p", {{"class", "figure-title"}}, title)) +
                     element("div",
                             {{"class", "chart"},
                              {"id", id},
                              {"role", "img"},
                              {"aria-label", words},
                              {"data-paper-share", paper_share},
                              {"style", "height:" + std::to_string(height) + "px"}},
                             "") +
                     (caption.empty() ? "" : text_element("figcaption", {}, caption)));
}

std::string note(const std::string& text) { return text_element("p", {{"class", "note"}}, text); }
std::string heading(const std::string& text) { return text_element("h3", {}, text); }

/// The part of the paper's width that each of n figures side by side has; three at most stand so.
std::string paper_share(std::size_t n) { return n > 2 ? "0.32" : n == 2 ? "0.485" : ""; }

/// n figures side by side.
std::string columns(const std::string& figures, std::size_t n) {
  const std::string style = "--columns:" + std::to_string(std::min<std::size_t>(n, 3));
  return element("div", {{"class", "columns"}, {"style", style}}, figures);
}

std::string tables_html(const std::vector<Table>& tables) {
  std::string html;
  for (const Table& table : tables) html += plain_table(table);
  return html;
}

std::string numbered(const char* id, std::size_t i) {
  return std::string(id) + "-" + std::to_string(i + 1);
}

/// What the points of a figure are, and how many of them there are not.
std::string points_in_words(const std::vector<const MeasuredValues*>& all) {
  std::int64_t n_values = 0, n_unbounded = 0;
  bool bands = false, at_zero = false;
  for (const MeasuredValues* measured : all) {
    bands = bands || measured->has_bands();
    for (Eigen::Index f = 0; f < measured->values.rows(); ++f) {
      for (Eigen::Index s = 0; s < measured->values.cols(); ++s) {
        if (!std::isfinite(measured->values(f, s))) continue;
        ++n_values;
        if (!measured->is_bounded(f, s)) {
          ++n_unbounded;
        } else if (measured->has_bands() && measured->lower(f, s) == 0) {
          at_zero = true;
        }
      }
    }
  }
  if (n_values == 0) return "";
  std::string words = " Points: measured";
  if (bands) words += ", with their 95 % bands";
  if (at_zero) words += "; a value whose bar reaches the bottom may as well be zero";
  words += ".";
  if (n_unbounded > 0) {
    words += " Left out: " + std::to_string(n_unbounded) + " of " + std::to_string(n_values) +
             " measured values, of which noise leaves nothing known (their bands have no upper "
             "end).";
  }
  return words;
}

std::string singular_values_html(const SingularValueFigure& figure) {
  const bool open = !figure.open_measured.frequencies_hz.empty(),
             closed = !figure.closed_measured.frequencies_hz.empty();
  const bool error = figure.open_measured.difference_db.size() > 0 ||
                     figure.closed_measured.difference_db.size() > 0;
  std::string words = "Singular values from " + figure.quantity + " over frequency, predicted";
  if (open || closed) {
    const auto& f = (closed ? figure.closed_measured : figure.open_measured).frequencies_hz;
    words += " and measured at " + std::to_string(f.size()) + " frequencies";
  }
  std::string caption = figure.of_floor ? "" : "From " + figure.quantity + ". ";
  caption += "Lines: predicted, open loop and closed loop as the sampled loop must show them";
  if (figure.closed_continuous.size() > 0) {
    caption += "; dashed: the continuous design, whose distance is the price of sampling";
  }
  caption += ".";
  caption += " The largest is what inputs that move each on their own can do at most";
  caption += figure.of_floor
                 ? ": a frame that follows its floor is above 1 (0 dB) wherever several inputs "
                   "share its motion. For a floor that moves as one, see the transmissibility."
                 : ".";
  caption += points_in_words({&figure.open_measured, &figure.closed_measured});
  if (error) caption += " Below: measured less predicted.";
  return chart("fig-singular-values", words, error ? 620 : 440, "", caption);
}

std::string transmissibility_html(const std::vector<TransmissibilityAxis>& axes) {
  std::string figures;
  std::vector<const MeasuredValues*> measured;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    figures += chart(numbered("fig-transmissibility", i),
                     "Transmissibility of axis " + axes[i].axis + " over frequency", 300,
                     "Axis " + axes[i].axis, "", paper_share(axes.size()));
    measured.insert(measured.end(), {&axes[i].passive_measured, &axes[i].active_measured});
  }
  return note(
             "Motion of the frame over motion of the floor, axis by axis; below the line at 1 the "
             "frame is quieter than the floor." +
             points_in_words(measured)) +
         columns(figures, axes.size());
}

std::string fit_html(const std::vector<TransmissibilityAxis>& legs) {
  std::string figures;
  std::vector<const MeasuredValues*> measured;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    figures += chart(numbered("fig-fit", i),
                     "Force sensor over actuator of " + legs[i].axis + ", measured and fitted", 300,
                     legs[i].axis, "", paper_share(legs.size()));
    measured.push_back(&legs[i].active_measured);
  }
  return note("Reading of each leg's force sensor over the force of its actuator, leg by leg." +
              points_in_words(measured)) +
         columns(figures, legs.size());
}

std::string modes_html(const ModeShapes& shapes) {
  std::string figures;
  for (std::size_t i = 0; i < shapes.modes.size(); ++i) {
    const ModeShape& mode = shapes.modes[i];
    std::string words = number_text(mode.frequency_hz, 4) + " Hz";
    const std::string canvas = element(
        "canvas",
        {{"id", numbered("fig-mode", i)},
         {"role", "img"},
         {"tabindex", "0"},
         {"aria-label", "Mode " + std::to_string(i + 1) + " at " + words + ", arrow keys turn it"}},
        "");
    std::string below = text_element("b", {}, words);
    if (mode.damping_ratio) {
      below += text_element("span", {{"class", "note"}},
                            "damping ratio " + number_text(*mode.damping_ratio, 2));
    }
    figures += element("figure", {}, canvas + element("figcaption", {}, below));
  }
  const std::string play =
      element("div", {{"class", "toolbar"}},
              text_element("button", {{"id", "modes-play"}, {"type", "button"}}, "Pause") +
                  text_element("button", {{"id", "modes-view"}, {"type", "button"}}, "Reset view") +
                  text_element("span", {{"class", "note"}},
                               "Drag a picture, or use its arrow keys, to turn all of them. "
                               "Motion is exaggerated; grey is the frame at rest."));
  return play + element("div", {{"class", "modes"}}, figures);
}

std::string histories_html(const PageData& data) {
  std::string html = element(
      "div", {{"class", "toolbar"}, {"id", "history-tools"}},
      text_element("button", {{"data-zoom", "in"}, {"aria-label", "Zoom in"}}, "+") +
          text_element("button", {{"data-zoom", "out"}, {"aria-label", "Zoom out"}}, "\u2212") +
          text_element("button", {{"data-zoom", "left"}, {"aria-label", "Earlier"}}, "\u2190") +
          text_element("button", {{"data-zoom", "right"}, {"aria-label", "Later"}}, "\u2192") +
          text_element("button", {{"data-zoom", "all"}}, "Whole run") +
          text_element("span", {{"class", "note"}},
                       "Drag to move, Ctrl and wheel or pinch to zoom; all histories follow."));
  for (std::size_t i = 0; i < data.histories.size(); ++i) {
    const HistoryAxis& axis = data.histories[i];
    const int panels = axis.passive.empty() || (axis.active.empty() && axis.floor.empty()) ? 1 : 2;
    html += chart(numbered("fig-history", i), "Acceleration of axis " + axis.axis + " over time",
                  panels == 2 ? 330 : 210, "Axis " + axis.axis + ", " + axis.unit);
  }
  if (!data.leg_forces.empty()) {
    html += chart("fig-legs", "Force of each leg over time",
                  50 + 72 * static_cast<int>(data.leg_forces.size()), "Forces of the legs, N");
  }
  return html + note(
                    "Drawn from the smallest and the largest sample of each stretch of time, so "
                    "that no peak is hidden; values are kept to 1/65532 of each signal's range.");
}

std::string spectra_html(const SpectraFigures& spectra) {
  const auto row = [&](const char* id, const char* what, SignalCurves SpectraAxis::*part,
                       int height) {
    std::string figures;
    for (std::size_t i = 0; i < spectra.axes.size(); ++i) {
      const SpectraAxis& axis = spectra.axes[i];
      const SignalCurves& curves = axis.*part;
      if (curves.floor.empty() && curves.passive.empty() && curves.active.empty()) continue;
      figures += chart(numbered(id, i), std::string(what) + " of axis " + axis.axis, height,
                       "Axis " + axis.axis, "", paper_share(spectra.axes.size()));
    }
    return figures;
  };
  std::string html;
  const auto add = [&](const std::string& figures, const std::string& title,
                       const std::string& words) {
    if (!figures.empty())
      html += heading(title) + note(words) + columns(figures, spectra.axes.size());
  };
  add(row("fig-octaves", "One-third-octave velocity", &SpectraAxis::third_octaves, 320),
      "One-third-octave velocity",
      "Velocity in each one-third-octave band, \u00b5m/s rms, against the generic vibration "
      "criteria.");
  add(row("fig-density", "Power spectral density of acceleration", &SpectraAxis::density, 300),
      "Power spectral density of acceleration",
      spectra.models.empty() ? "(m/s\u00b2)\u00b2/Hz."
                             : "(m/s\u00b2)\u00b2/Hz; dashed: Peterson\u2019s noise models of "
                               "quiet ground (NLNM, the lower one) and of noisy ground (NHNM).");
  add(row("fig-cumulative", "Cumulative rms acceleration", &SpectraAxis::cumulative_rms, 260),
      "Cumulative rms acceleration",
      "mm/s\u00b2 from the lowest frequency up to each: where it rises, there the motion is.");
  return html;
}

std::string timing_html(const PageData& data) {
  std::string figures;
  for (std::size_t i = 0; i < data.histograms.size(); ++i) {
    figures += chart(numbered("fig-histogram", i), "How often: " + data.histograms[i].name, 240,
                     data.histograms[i].name, "", paper_share(data.histograms.size()));
  }
  return tables_html(data.timing) +
         (figures.empty() ? "" : columns(figures, data.histograms.size()));
}

std::string record_html(const PageData& data) {
  std::string html;
  const auto part = [&](const std::string& name, const std::string& body, bool open) {
    if (body.empty()) return;
    html += std::string(open ? "<details open>" : "<details>") + text_element("summary", {}, name) +
            body + "</details>\n";
  };
  part("Quality of the logs", tables_html(data.log), true);
  std::string gains;
  for (const MatrixTable& matrix : data.gains) gains += matrix_table(matrix);
  part("Gains", gains, true);
  for (const Text& text : data.texts)
    part(text.name, text_element("pre", {{"tabindex", "0"}}, text.text), false);
  return html;
}

std::string facts_html(const Head& head) {
  std::string html;
  const auto fact = [&](const char* name, const std::string& value) {
    if (value.empty()) return;
    html += element("div", {}, text_element("dt", {}, name) + text_element("dd", {}, value));
  };
  std::string loops;
  for (const std::string& loop : head.loops) loops += (loops.empty() ? "" : ", ") + loop;
  fact("Loops", loops);
  fact("Mode", head.mode);
  const auto quantity = [&](const char* name, std::optional<double> value, const char* unit) {
    if (value && std::isfinite(*value)) fact(name, short_number(*value) + unit);
  };
  quantity("Rate", head.sample_rate_hz, " Hz");
  quantity("Duration", head.duration_s, " s");
  quantity("Delay", head.delay_samples, head.delay_samples == 1 ? " sample" : " samples");
  fact("Run on", head.date);
  fact("Scene", head.scene_name);
  fact("Scene hash", head.scene_hash);
  fact("Program", head.program_version);
  return html.empty() ? "" : element("dl", {{"class", "facts"}}, html);
}

std::string warnings_html(std::vector<Warning> warnings) {
  if (warnings.empty()) return "";
  std::stable_sort(warnings.begin(), warnings.end(), [](const Warning& a, const Warning& b) {
    return static_cast<int>(a.severity) < static_cast<int>(b.severity);
  });
  static constexpr const char* classes[] = {"severe", "warning", "remark"};
  static constexpr const char* names[] = {"Severe", "Warning", "Note"};
  std::string items;
  for (const Warning& warning : warnings) {
    const auto i = static_cast<std::size_t>(warning.severity);
    items += element("li", {{"class", classes[i]}},
                     element("b", {}, names[i]) + " " + escape(warning.text));
  }
  return element("ul", {{"class", "warnings"}, {"aria-label", "Warnings"}}, items);
}

std::string verdict_html(const Head& head) {
  if (!head.outcome) return "";
  const bool passed = *head.outcome == report::Outcome::passed,
             failed = *head.outcome == report::Outcome::failed;
  std::string word(report::to_text(*head.outcome));
  word.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
  std::string html = text_element("span",
                                  {{"class", passed   ? "badge pass"
                                             : failed ? "badge fail"
                                                      : "badge open"}},
                                  word);
  std::string reasons;
  for (const std::string& reason : head.reasons) reasons += text_element("li", {}, reason);
  if (!reasons.empty()) html += element("ul", {{"class", "reasons"}}, reasons);
  return element("div", {{"class", "verdict"}}, html);
}

}  // namespace

std::string head_html(const PageData& data) {
  const Head& head = data.head;
  std::string html =
      element("div", {{"class", "title-row"}},
              element("div", {},
                      text_element("p", {{"class", "kicker"}}, "stillframe report") +
                          text_element("h1", {}, head.title)) +
                  text_element("button", {{"id", "scheme"}, {"type", "button"}}, "Dark"));
  html += warnings_html(data.warnings) + verdict_html(head);
  for (const std::string& line : head.headlines) {
    html += text_element("p", {{"class", "headline"}}, line);
  }
  return html + facts_html(head);
}

std::vector<Section> sections(const PageData& data) {
  std::vector<Section> list;
  const auto add = [&](const char* id, const char* name, const std::string& body,
                       bool one_sheet = true) {
    if (!body.empty()) list.push_back({id, name, body, one_sheet});
  };
  add("result", "Result",
      (data.result.empty() ? "" : result_table(data.result)) + tables_html(data.checks));
  if (data.singular_values) {
    add("singular-values", "Singular values", singular_values_html(*data.singular_values));
  }
  if (!data.transmissibility.empty()) {
    add("transmissibility", "Transmissibility", transmissibility_html(data.transmissibility));
  }
  if (!data.fit.empty()) add("fit", "Fit", fit_html(data.fit));
  if (data.modes && !data.modes->modes.empty()) {
    add("modes", "Mode shapes", modes_html(*data.modes));
  }
  if (!data.histories.empty() || !data.leg_forces.empty()) {
    add("histories", "Time histories", histories_html(data), false);
  }
  if (!data.spectra.axes.empty()) {
    add("spectra", "Spectra", spectra_html(data.spectra), false);
  }
  add("shock", "Settling after a shock", tables_html(data.shock));
  add("noise", "Noise floor", tables_html(data.noise));
  add("effort", "Actuator effort", tables_html(data.effort));
  add("timing", "Timing", timing_html(data));
  add("record", "Record", record_html(data), false);
  return list;
}

}  // namespace stillframe::page

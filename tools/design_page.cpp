#include "tools/design_page.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/errors/formatted.hpp"
#include "core/numerics/decibels.hpp"
#include "report/table.hpp"
#include "tools/matrix_table.hpp"
#include "tools/reduction_text.hpp"

namespace stillframe::tools {

namespace {

std::string listed(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + formatted("%g", value);
  return text;
}

std::string instruments_line(const Instruments& has) {
  if (has.ideal()) return "";
  std::string text = "Instruments:";
  if (has.actuator_lag_hz > 0) text += formatted(" actuators of %g Hz;", has.actuator_lag_hz);
  if (has.sensor_filter_hz > 0) text += formatted(" sensor filter of %g Hz;", has.sensor_filter_hz);
  if (has.actuator_gain != 1) text += formatted(" actuator gain %g;", has.actuator_gain);
  text += has.report == Instruments::Report::measured ? " applied force measured"
                                                      : " applied force taken from the command";
  if (has.report_age_samples > 0) text += formatted(", %d sample(s) old", has.report_age_samples);
  return text + "\n";
}

std::string feed_forward_line(const judge::LoopDesign& design) {
  const auto& block = design.scene.controller->feed_forward;
  if (!block) return "";
  if (design.gains.feed_forward.filter.empty()) {
    return "Feed-forward: none is designed on a feedback that is not stable\n";
  }
  std::string of;
  if (block->target_hz) of += formatted(" of target %g Hz", *block->target_hz);
  if (block->damping_ratio) of += formatted(" of damping %g", *block->damping_ratio);
  return formatted(
      "Feed-forward from %td accelerations of the floor: the continuous law's T%s is aimed at from "
      "%g to %g Hz,\n%g dB from %g Hz on; %d taps; \"closed\" below has it, margins are the "
      "feedback's\n",
      std::ssize(design.gains.feed_forward.floor), of.c_str(), block->corner_hz, block->to_hz,
      block->at_most_db, 1.5 * block->to_hz, block->taps);
}

/// What a law of one's own hears: "6 sigma, 6 applied forces".
std::string heard(const NamedLaw& law) {
  std::string text;
  for (const auto& [prefix, what] :
       {std::pair(sigma_prefix, "sigma"), std::pair(applied_prefix, "applied forces"),
        std::pair(strain_prefix, "strain forces"),
        std::pair(floor_prefix, "accelerations of the floor")}) {
    const auto n = std::count_if(law.inputs.begin(), law.inputs.end(),
                                 [&](const std::string& name) { return name.starts_with(prefix); });
    if (n > 0) text += (text.empty() ? "" : ", ") + formatted("%td %s", n, what);
  }
  return text;
}

std::string own_law_lines(const judge::LoopDesign& design) {
  const SceneController& block = *design.scene.controller;
  const NamedLaw& law = design.gains.law->matrices;
  return formatted(
      "Law of %s: %td states, hears %s\n"
      "Held against (\"continuous\") the PI of target %s Hz, damping %s, without sampling\n"
      "Sampled at %g Hz, a command acts %g sample(s) after its measurement\n",
      block.law->file.c_str(), law.A.rows(), heard(law).c_str(), listed(block.target_hz).c_str(),
      listed(block.damping_ratio).c_str(), block.sample_rate_hz, block.delay_samples);
}

std::string heading(const judge::LoopDesign& design) {
  const SceneController& block = *design.scene.controller;
  std::string text = design.scene.title + "\n";
  if (design.runs_own_law()) {
    text += own_law_lines(design) + feed_forward_line(design);
    return text + instruments_line(design.scene.instruments);
  }
  const std::string origin = design.has_own_gains()
                                 ? "K_P and K_I of " + block.law->file
                                 : formatted("order %s: X = I + K_P = %s / omega_d^2",
                                             block.order == GainOrder::exact ? "exact" : "deck",
                                             block.order == GainOrder::exact ? "K M^-1" : "M^-1 K");
  text += formatted("Target %s Hz, damping %s; %s; leak %g Hz", listed(block.target_hz).c_str(),
                    listed(block.damping_ratio).c_str(), origin.c_str(), block.leak_hz);
  if (block.high_pass_hz > 0) text += formatted(", high-pass %g Hz", block.high_pass_hz);
  if (block.roll_off_hz) text += formatted(", roll-off %g Hz", *block.roll_off_hz);
  text += formatted(
      "\nSampled at %g Hz, a command acts %g sample(s) after its measurement, lead %g "
      "sample(s)\n",
      block.sample_rate_hz, block.delay_samples, block.lead_samples);
  text += feed_forward_line(design);
  return text + instruments_line(design.scene.instruments);
}

std::string remarks_text(const Remarks& remarks) {
  std::string text;
  if (!remarks.warnings.empty()) text += "\nWarnings\n";
  for (const std::string& warning : remarks.warnings) text += "  ! " + warning + "\n";
  if (!remarks.notes.empty()) text += "\nNotes\n";
  for (const std::string& note : remarks.notes) text += "  - " + note + "\n";
  return text;
}

std::string poles_text(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  const bool exact = design.scene.controller->order == GainOrder::exact;
  std::string text;
  if (const auto& used = exact ? analysis.exact : analysis.deck) {
    text = formatted(
        "Design model, no leak: poles at %.6f to %.6f of what their targets ask for, largest real "
        "part %.4g 1/s\n",
        used->lowest, used->highest, used->largest_real);
  }
  text += formatted("Poles of the continuous law on the whole plant, all %td (rad/s):\n ",
                    analysis.poles.size());
  size_t column = 0;
  for (const auto& pole : analysis.poles) {
    if (pole.imag() < 0) continue;  // of a pair, one is shown
    if (column == 4) {
      text += "\n ";
      column = 0;
    }
    ++column;
    text += pole.imag() > 0 ? formatted("  %10.4g +-%9.4gj", pole.real(), pole.imag())
                            : formatted("  %10.4g %12s", pole.real(), "");
  }
  return text + "\n";
}

/// A line of the table and, where it is there for a peak, of what.
struct TableLine {
  const FrequencyLine* line = nullptr;
  const judge::PeakRow* peak = nullptr;
};

/// Round frequencies and the peaks between them, ascending.
std::vector<TableLine> lines_of(const DesignAnalysis& analysis) {
  std::vector<TableLine> lines;
  for (const FrequencyLine& line : analysis.lines) lines.push_back({&line, nullptr});
  for (const PeakLine& peak : analysis.peaks) lines.push_back({&peak.line, &peak.row});
  std::sort(lines.begin(), lines.end(),
            [](const TableLine& a, const TableLine& b) { return a.line->hz < b.line->hz; });
  return lines;
}

std::string transfer_text(const DesignAnalysis& analysis) {
  std::string text =
      "Floor to frame (largest singular value of T), noise of the force sensors to frame, and how "
      "far a force on the\nframe moves it against no control; all of the loop that runs, but for "
      "its continuous law: without sampling,\ndelay and instruments. The largest singular value is "
      "what inputs that move each on their own can do at most:\na frame that follows its floor is "
      "above 0 dB wherever several inputs share its motion\n";
  const bool square = !analysis.lines.empty() && analysis.lines.front().decoupling.has_value();
  std::vector<std::string> header{"Hz",       "open dB",       "closed dB",
                                  "force dB", "noise um/s2/N", "continuous dB"};
  if (square) header.insert(header.end(), {"spread dB", "crosstalk dB"});
  const std::vector<TableLine> lines = lines_of(analysis);
  if (!analysis.peaks.empty()) header.push_back("peak of");
  report::Table table(header, 0);
  for (const auto& [line_there, peak] : lines) {
    const FrequencyLine& line = *line_there;
    // At its own pole an undamped response has no value.
    const auto gain = [&, peak = peak](double value, judge::PeakRow::Of of) {
      const bool unbounded = peak && peak->of == of && std::isinf(peak->peak.value);
      return unbounded ? "inf" : formatted("%.1f", decibels(value));
    };
    const double force = decibels(line.compliance / line.passive_compliance);
    const bool passive_unbounded =
        peak && peak->of == judge::PeakRow::Of::open && std::isinf(peak->peak.value);
    std::vector<std::string> row{formatted(peak ? "%.4g" : "%g", line.hz),
                                 gain(line.open(0), judge::PeakRow::Of::open),
                                 gain(line.closed(0), judge::PeakRow::Of::closed),
                                 passive_unbounded ? "-" : formatted("%.1f", force),
                                 formatted("%.4g", 1e6 * line.noise),
                                 gain(line.continuous(0), judge::PeakRow::Of::continuous)};
    if (line.decoupling) {
      row.push_back(formatted("%.2f", line.decoupling->spread_db));
      // Nothing reaches another output, and there may be no other.
      const double crosstalk = line.decoupling->crosstalk_db;
      row.push_back(std::isinf(crosstalk) ? "-" : formatted("%.1f", crosstalk));
    }
    if (!analysis.peaks.empty()) row.push_back(peak ? judge::name_of(peak->of) : "");
    table.add(row);
  }
  text += table.print();
  if (square) {
    text +=
        "spread: largest over smallest singular value of the loop that runs; crosstalk: what gets "
        "from an input to\nother outputs than the one of the same number, over what gets to that\n";
  }
  return text;
}

std::string factor(double value) {
  return value == 0 || std::isinf(value) ? "no limit" : formatted("%.3g", value);
}

std::string milliseconds(double seconds, double sample_time) {
  return std::isinf(seconds) ? formatted("> %.3g", 1e3 * longest_delay * sample_time)
                             : formatted("%.3g", 1e3 * seconds);
}

std::string margins_text(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  if (!analysis.margins) return "";
  const Margins& margins = *analysis.margins;
  std::string text =
      "Margins (force that acts over force that is reported; delay beyond the scene's; disk: both "
      "at "
      "once)\n";
  report::Table table({"leg", "gain down", "gain up", "delay ms", "disk", "disk degrees"}, 1);
  const auto add = [&](const std::string& name, const GainRange& gain, double delay, double disk) {
    const bool known = !std::isnan(disk);
    table.add({name, factor(gain.lowest), factor(gain.highest),
               milliseconds(delay, design.gains.sample_time()),
               known ? formatted("%.3f", disk) : "not known",
               known ? formatted("%.1f", 2 * std::atan(disk / 2) * 180 / std::numbers::pi) : ""});
  };
  for (size_t i = 0; i < margins.leg_gain.size(); ++i) {
    const auto j = static_cast<Index>(i);
    add(design.gains.legs[i], margins.leg_gain[i], margins.leg_delay(j), margins.leg_disk(j));
  }
  add("all at once", margins.all_gain, margins.all_delay, margins.all_disk);
  text += table.print();
  if (!margins.delays_proven) {
    text +=
        "not all delays are proven: 64 of each sample were tried, one between may be unstable\n";
  }
  return text;
}

std::string limits_text(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  std::string text = formatted(
      "Sampled closed loop: spectral radius %.9f; with the applied force "
      "reported one sample late %.9f\n",
      analysis.radius, analysis.misaligned_radius);
  if (design.runs_own_law()) return text;
  text += "Stable rates:";
  for (const auto& [slowest, fastest] : analysis.rates) {
    text +=
        formatted(" %.4g Hz to %.4g Hz%s;", slowest, fastest, fastest >= 2e5 ? " and more" : "");
  }
  if (analysis.rates.empty()) text += " none;";
  if (analysis.recommended) {
    const Recommendation& best = *analysis.recommended;
    text +=
        formatted(" recommended: %g Hz with lead_samples: %.3g", best.rate_hz, best.lead_samples);
    text += best.roll_off_hz ? formatted(" and roll_off_hz: %g", *best.roll_off_hz)
                             : " and no roll-off";
    text += formatted(
        " (up to four targets within %.1f dB of the law without sampling, disk margin "
        "%.2f)\n",
        std::max(best.price_db, 0.0), best.disk);
    for (const std::string& warning : best.standing) text += "  there still: " + warning + "\n";
  } else {
    text += " no rate up to 100 kHz can be recommended: " + analysis.why_none + "\n";
  }
  return text;
}

Json margins_json(const Margins& margins) {
  const auto range = [](const GainRange& gain) { return Json{gain.lowest, gain.highest}; };
  Json legs = Json::array();
  for (const GainRange& gain : margins.leg_gain) legs.push_back(range(gain));
  return {{"leg_gain", legs},
          {"all_gain", range(margins.all_gain)},
          {"leg_delay_s", to_json(margins.leg_delay)},
          {"all_delay_s", margins.all_delay},
          {"delays_proven", margins.delays_proven},
          {"leg_disk", to_json(margins.leg_disk)},
          {"all_disk", margins.all_disk},
          {"all_disk_hz", margins.all_disk_hz}};
}

Json recommendation_json(const DesignAnalysis& analysis) {
  if (!analysis.recommended) return {};
  const Recommendation& best = *analysis.recommended;
  return {{"sample_rate_hz", best.rate_hz},
          {"lead_samples", best.lead_samples},
          {"roll_off_hz", best.roll_off_hz ? Json(*best.roll_off_hz) : Json()},
          {"price_db", best.price_db},
          {"disk", best.disk},
          {"warnings", best.standing}};
}

Json feed_forward_json(const judge::LoopDesign& design) {
  const auto& block = design.scene.controller->feed_forward;
  if (!block || design.gains.feed_forward.filter.empty()) return {};
  return {{"floor", design.gains.feed_forward.floor},
          {"to_hz", block->to_hz},
          {"corner_hz", block->corner_hz},
          {"target_hz", block->target_hz ? Json(*block->target_hz) : Json()},
          {"damping_ratio", block->damping_ratio ? Json(*block->damping_ratio) : Json()},
          {"at_most_db", block->at_most_db},
          {"actuator_error", block->actuator_error},
          {"noise_over_floor", block->noise_over_floor},
          {"taps", block->taps}};
}

Json spread_json(const std::optional<PoleSpread>& effect) {
  if (!effect) return {};
  return {{"lowest", effect->lowest},
          {"highest", effect->highest},
          {"largest_real", effect->largest_real}};
}

Json law_json(const judge::LoopDesign& design) {
  if (!design.scene.controller->law) return {};
  Json out;
  out["file"] = design.scene.controller->law->file;
  const NamedLaw* law = design.runs_own_law() ? &design.gains.law->matrices : nullptr;
  out["n_states"] = law ? Json(law->A.rows()) : Json();
  out["inputs"] = law ? Json(law->inputs) : Json();
  out["outputs"] = law ? Json(law->outputs) : Json();
  return out;
}

}  // namespace

std::string design_page(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  const std::string by_the_clock =
      design.scene.controller->force_limit_n
          ? ""
          : "force_limit_n is not given: stillframe run --mode wall_clock asks for it\n";
  const std::string gains = design.runs_own_law()
                                ? ""
                                : matrix_table("K_P (1)", design.gains.K_P) +
                                      matrix_table("K_I (1/s)", design.gains.K_I) + "\n" +
                                      poles_text(design, analysis) + "\n";
  const std::string reduction =
      analysis.reduced ? "\nPassive scene, floor to frame. " + reduction_text(*analysis.reduced)
                       : "";
  return heading(design) + reduction + remarks_text(analysis.remarks) + "\n" + gains +
         transfer_text(analysis) + "\n" + margins_text(design, analysis) + "\n" +
         limits_text(design, analysis) + by_the_clock;
}

Json design_json(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  const SceneController& block = *design.scene.controller;
  Json frequencies = Json::array(), open = Json::array(), closed = Json::array(),
       continuous = Json::array(), noise = Json::array(), compliance = Json::array(),
       passive = Json::array(), spread = Json::array(), crosstalk = Json::array(),
       rates = Json::array();
  for (const FrequencyLine& line : analysis.lines) {
    frequencies.push_back(line.hz);
    open.push_back(to_json(line.open));
    closed.push_back(to_json(line.closed));
    continuous.push_back(to_json(line.continuous));
    noise.push_back(line.noise);
    compliance.push_back(line.compliance);
    passive.push_back(line.passive_compliance);
    spread.push_back(line.decoupling ? Json(line.decoupling->spread_db) : Json());
    crosstalk.push_back(line.decoupling ? Json(line.decoupling->crosstalk_db) : Json());
  }
  for (const auto& [slowest, fastest] : analysis.rates) rates.push_back({slowest, fastest});
  const bool own = design.runs_own_law();
  Json peaks = Json::array();
  for (const auto& [row, line] : analysis.peaks) {
    peaks.push_back(
        {{"of", judge::name_of(row.of)}, {"hz", row.peak.hz}, {"singular_value", row.peak.value}});
  }
  Json out{{"scene", design.scene.title},
           {"scene_hash", design.scene.hash},
           {"order", block.law ? Json() : Json(block.order == GainOrder::exact ? "exact" : "deck")},
           {"law", law_json(design)},
           {"legs", design.gains.legs},
           {"target_hz", block.target_hz},
           {"damping_ratio", block.damping_ratio},
           {"K_P", own ? Json() : to_json(design.gains.K_P)},
           {"K_I", own ? Json() : to_json(design.gains.K_I)},
           {"leak_hz", design.gains.leak_hz},
           {"feed_forward", feed_forward_json(design)},
           {"closed_loop_poles", own ? Json() : to_json(analysis.poles)},
           {"exact_order", spread_json(analysis.exact)},
           {"deck_order", spread_json(analysis.deck)},
           {"spectral_radius", analysis.radius},
           {"misaligned_spectral_radius", analysis.misaligned_radius},
           {"reduction", analysis.reduced ? reduction_json(*analysis.reduced) : Json()},
           {"frequencies_hz", frequencies},
           {"singular_values", open},
           {"closed_singular_values", closed},
           {"continuous_singular_values", continuous},
           {"noise_m_s2_per_n", noise},
           {"compliance", compliance},
           {"passive_compliance", passive},
           {"spread_db", spread},
           {"crosstalk_db", crosstalk},
           {"peaks", peaks},
           {"margins", analysis.margins ? margins_json(*analysis.margins) : Json()},
           {"stable_rates_hz", own ? Json() : rates},
           {"recommended", recommendation_json(analysis)},
           {"warnings", analysis.remarks.warnings},
           {"notes", analysis.remarks.notes}};
  return out;
}

}  // namespace stillframe::tools

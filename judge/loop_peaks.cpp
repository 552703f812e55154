#include "judge/loop_peaks.hpp"

#include <algorithm>

#include "core/control/continuous_loop.hpp"
#include "core/mechanics/frequency_response.hpp"

namespace stillframe::judge {

LoopGains gains_of(const LoopDesign& design) {
  const LoopPlant& plant = design.settings.plant;
  return {LargestGain(design.open), LargestGain(design.closed),
          LargestGain(continuous_loop(plant, design.loop.gains), plant.B_w.cols())};
}

const char* name_of(PeakRow::Of of) {
  return of == PeakRow::Of::open ? "open" : of == PeakRow::Of::closed ? "closed" : "continuous";
}

std::vector<PeakRow> peak_rows(const Eigen::VectorXd& frequencies_hz, LoopGains& gains,
                               double sample_rate_hz) {
  std::vector<PeakRow> rows;
  const auto add = [&](LargestGain& gain, PeakRow::Of of, Index n) {
    for (const Peak& peak : peaks_between(frequencies_hz.head(n), gain)) rows.push_back({peak, of});
  };
  const bool sampled = gains.closed.has_value();
  const Index n_sampled = (frequencies_hz.array() <= sample_rate_hz / 2).count();
  add(gains.open, PeakRow::Of::open, sampled ? n_sampled : frequencies_hz.size());
  if (sampled) add(*gains.closed, PeakRow::Of::closed, n_sampled);
  if (gains.continuous) add(*gains.continuous, PeakRow::Of::continuous, frequencies_hz.size());
  std::sort(rows.begin(), rows.end(),
            [](const PeakRow& a, const PeakRow& b) { return a.peak.hz < b.peak.hz; });
  return rows;
}

Eigen::VectorXd with_resonances_of(const LoopGains& gains, const Eigen::VectorXd& frequencies_hz) {
  std::vector<Resonance> all = gains.open.resonances();
  for (const auto* gain : {&gains.closed, &gains.continuous}) {
    if (!*gain) continue;
    all.insert(all.end(), (*gain)->resonances().begin(), (*gain)->resonances().end());
  }
  return with_resonances(frequencies_hz, all);
}

std::vector<double> picture_frequencies(const LoopDesign& design, const FrequencyRange& range) {
  const Eigen::VectorXd fine = with_resonances_of(
      gains_of(design), logarithmic_frequencies(range.lowest_hz, range.highest_hz, 600));
  return {fine.begin(), fine.end()};
}

}  // namespace stillframe::judge

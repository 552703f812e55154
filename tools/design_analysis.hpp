#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/control/continuous_loop.hpp"
#include "core/control/margins.hpp"
#include "core/mechanics/sparse/reduced_model.hpp"
#include "judge/loop_design.hpp"
#include "judge/loop_peaks.hpp"
#include "tools/remarks.hpp"

namespace stillframe::tools {

/// What the loop that runs does at one frequency, and its continuous law beside it; singular values
/// are largest first.
struct FrequencyLine {
  double hz = 0;
  Eigen::VectorXd open, closed, continuous;  ///< of T: passive, the loop that runs, its law alone
  double noise = 0;                      ///< largest singular value, m/s^2 per N of sensor noise
  double compliance = 0;                 ///< largest singular value, m/N
  double passive_compliance = 0;         ///< the same with the loop open
  std::optional<Decoupling> decoupling;  ///< of the T that runs, where inputs and outputs pair up
};

/// The line at a peak that the others miss.
struct PeakLine {
  judge::PeakRow row;
  FrequencyLine line;
};

/// How the continuous poles lie about their targets.
struct PoleSpread {
  double lowest = 0, highest = 0;  ///< modulus over that of the nearest pole that a target asks for
  double largest_real = 0;         ///< 1/s
};

/// A sample rate that is worth its price, with the lead and roll-off that make it so.
struct Recommendation {
  double rate_hz = 0, lead_samples = 0;
  std::optional<double> roll_off_hz;
  double price_db = 0;  ///< largest excess of the sampled T over the law without sampling and
                        ///< roll-off, up to four targets
  double disk = 0;      ///< all-leg disk margin
  std::vector<std::string>
      standing;  ///< what the page of a loop with these settings still warns of
};

/// Everything that the design page says.
struct DesignAnalysis {
  /// Of a scene with `reduce`: its inputs to its outputs.
  std::optional<ReducedModel> reduced;
  /// Of the continuous loop with the whole plant, slowest first; none with a law of one's own,
  /// which has no continuous form.
  Eigen::VectorXcd poles;
  std::optional<PoleSpread> exact, deck;  ///< on the design model, without leak, of designed gains
  std::vector<FrequencyLine> lines;       ///< at round frequencies
  std::vector<PeakLine> peaks;            ///< between them
  double radius = 0;
  double misaligned_radius = 0;  ///< with the reported force one sample older
  std::optional<Margins> margins;
  std::string widened;  ///< what widens a thin disk margin, in words; empty if it is not thin
  std::vector<std::pair<double, double>> rates;  ///< stable ones, Hz
  std::optional<Recommendation> recommended;
  std::string why_none;  ///< recommended, in words; empty if one is
  Remarks remarks;
};

/// The disk margin of all legs below which one is warned of it.
inline constexpr double least_disk_margin = 0.5;
/// The price of sampling, dB, above which no rate is recommended.
inline constexpr double most_price_db = 3;

/// Analyses a design; an unstable one has no margins. progress: told what comes next. Errors: as
/// margins and the core's.
DesignAnalysis analyse(const judge::LoopDesign& design,
                       const std::function<void(const std::string&)>& progress);

/// Roll-offs that are tried, in targets, those that change least first; 0: the loop's own, with its
/// own lead.
inline constexpr double tried_roll_offs[] = {0, 80, 40, 20};

/// A loop with one of those roll-offs, and the lead that is matched to it.
LoopSettings tuned(const LoopSettings& settings, double target_hz, double roll_off_targets);

/// The lowest of the rates 1, 2, 5, 10, ... (Hz) up to 100 kHz at which the price of sampling is at
/// most 3 dB, the all-leg disk margin at least 0.5 (factors 0.6 to 1.67, 28 degrees), and of which
/// settings_warnings has nothing to say: with the scene's lead and roll-off if that does, or with a
/// roll-off at 20, 40 or 80 times the lowest target and the lead that matches it. Delay stays so
/// many samples. What could not be computed recommends nothing.
std::optional<Recommendation> recommend(const judge::LoopDesign& design);
/// The same with other settings than the scene's.
std::optional<Recommendation> recommend(const judge::LoopDesign& design, const LoopSettings& own);

}  // namespace stillframe::tools

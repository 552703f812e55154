#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/linear/continuous_loop.hpp"
#include "core/linear/margins.hpp"
#include "tools/loop_design.hpp"

namespace stillframe::tools {

/// What the loop does at one frequency; singular values are largest first.
struct FrequencyLine {
  double hz = 0;
  Eigen::VectorXd open, closed, sampled;  ///< of T: passive, continuous law, as it is sampled
  double noise = 0;       ///< largest singular value, m/s^2 per N of sensor noise, sampled
  double compliance = 0;  ///< largest singular value, m/N, continuous law
  double passive_compliance = 0;
  std::optional<Decoupling> decoupling;  ///< of the sampled T, where inputs and outputs pair up
};

/// How the continuous poles lie about their targets.
struct PoleSpread {
  double lowest = 0, highest = 0;  ///< modulus over omega_d of the modes' own target
  double largest_real = 0;         ///< 1/s
};

/// What the other order of the same matrices would do, or does.
struct OrderEffect {
  PoleSpread poles;
  bool same = false;  ///< K and M commute
};

/// A rate that is worth its price, and why; see recommended_rate.
struct RecommendedRate {
  double rate_hz = 0;
  double price_db = 0;  ///< largest excess of sampled over continuous T up to four targets
  double disk = 0;      ///< all-leg disk margin
};

/// Everything that the design page says.
struct DesignAnalysis {
  Eigen::VectorXcd poles;   ///< of the continuous loop with the whole plant, slowest first
  OrderEffect exact, deck;  ///< on the design model, without leak
  std::vector<FrequencyLine> lines;
  double radius = 0;
  double misaligned_radius = 0;  ///< with the reported force one sample older
  std::optional<Margins> margins;
  std::vector<std::pair<double, double>> rates;  ///< stable ones, Hz
  std::optional<RecommendedRate> recommended;
  std::vector<std::string> warnings;
};

/// Frequencies of the page's table, Hz.
inline constexpr double page_frequencies_hz[] = {1, 2, 5, 10, 20, 50, 100};

/// Analyses a design; an unstable one has no margins. Errors: as margins and the core's.
DesignAnalysis analyse(const LoopDesign& design);

/// The lowest of the rates 1, 2, 5, 10, ... (Hz) up to 100 kHz at which the sampled T stays within
/// `price_db` of the continuous one up to four times the lowest target, with an all-leg disk margin
/// of `disk` at least (0.5: factors 0.6 to 1.67, 28 degrees). Delay and lead stay so many samples.
std::optional<RecommendedRate> recommended_rate(const LoopDesign& design, double price_db = 3,
                                                double disk = 0.5);

}  // namespace stillframe::tools

#include "tools/design_trade.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/control/design/price_of_sampling.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/two_pi.hpp"
#include "tools/design_analysis.hpp"

namespace stillframe::tools {

namespace {

constexpr double factors[] = {0.4, 1, 2, 4};
constexpr double delays[] = {0, 1, 2};
constexpr Index n_rates = 17;

}  // namespace

ControlLoop retargeted(const judge::LoopDesign& design, double factor) {
  SceneController block = *design.scene.controller;
  for (double& target : block.target_hz) target *= factor;
  ControlLoop loop = design.loop;
  const auto targets = mode_targets(block, loop.design.legs.M.rows());
  const ForceFeedback gains = design_gains(loop.design, targets, block.order);
  loop.gains.K_P = gains.K_P;
  loop.gains.K_I = gains.K_I;
  return loop;
}

DesignTrade design_trade(const judge::LoopDesign& design,
                         const std::function<void(double)>& progress) {
  const double slowest = design.scene.controller->lowest_target_hz();
  DesignTrade trade{.rates_hz = logarithmic_frequencies(40 * slowest, 4000 * slowest, n_rates),
                    .curves = {}};
  const double total = static_cast<double>(std::size(delays) * std::size(factors));
  for (const double delay : delays) {
    for (const double factor : factors) {
      progress(static_cast<double>(trade.curves.size()) / total);
      const ControlLoop loop = retargeted(design, factor);
      const double target = factor * design.scene.controller->lowest_target_hz();
      const double nan = std::numeric_limits<double>::quiet_NaN();
      TradeCurve curve{.target_hz = target,
                       .delay_samples = delay,
                       .disk = Eigen::VectorXd::Constant(n_rates, nan),
                       .price_db = Eigen::VectorXd::Constant(n_rates, nan)};
      for (Index i = 0; i < n_rates; ++i) {
        LoopSettings settings = at_rate(design.settings, trade.rates_hz(i));
        settings.feedback = loop.gains;
        settings.sampling.delay_samples = delay;
        const double own = settings.feedback.roll_off;
        settings =
            with_roll_off(std::move(settings),
                          own > 0 ? own : two_pi * std::min(40 * target, 0.4 * trade.rates_hz(i)));
        if (!(spectral_radius(settings) < largest_stable_radius)) continue;
        curve.disk(i) = all_leg_disk_margin(settings).first;
        curve.price_db(i) = price_of_sampling(loop, target, settings);
      }
      trade.curves.push_back(std::move(curve));
    }
  }
  return trade;
}

}  // namespace stillframe::tools

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "judge/loop_design.hpp"

namespace stillframe::tools {

/// One target with one delay, over sample rates. NaN where the loop is unstable.
struct TradeCurve {
  double target_hz = 0, delay_samples = 0;
  Eigen::VectorXd disk;      ///< all-leg disk margin, 1
  Eigen::VectorXd price_db;  ///< price_of_sampling, dB
};

/// What target, rate and delay cost each other on one scene.
struct DesignTrade {
  Eigen::VectorXd rates_hz;
  std::vector<TradeCurve> curves;  ///< targets change fastest
};

/// The loop with gains for all targets times a factor.
ControlLoop retargeted(const judge::LoopDesign& design, double factor);

/// Designs the scene anew for 0.4, 1, 2 and 4 times its lowest target (the others keep their ratio
/// to it) and 0, 1 and 2 samples of delay, at 40 to 4000 times
/// the lowest target, each with the scene's roll-off, or one at 40 targets (but 0.4 rates at most)
/// if it has none, and the lead that matches. progress is told how much is done, 0 to 1. Errors: as
/// design_gains.
DesignTrade design_trade(const judge::LoopDesign& design,
                         const std::function<void(double)>& progress);

}  // namespace stillframe::tools

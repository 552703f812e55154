#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "judge/loop_design.hpp"
#include "judge/multisine_motion.hpp"
#include "plant_sim/floor/floor_block.hpp"

namespace stillframe::judge {

/// How a frame is held.
enum class BudgetMethod { passive, feedback, feed_forward };
const char* name_of(BudgetMethod method);

/// What one source does to one acceleration, or all of them do together.
struct BudgetPart {
  double rms = 0;            ///< m/s^2, by itself, over the samples of the run from its start on
  double share = 0;          ///< (m/s^2)^2, of the mean square of all sources together
  Eigen::VectorXd power;     ///< (m/s^2)^2 of every cell, by itself; together rms^2
  Eigen::VectorXd shared;    ///< (m/s^2)^2, share of the power of every cell; together `share`
  Eigen::VectorXd velocity;  ///< m/s rms, by itself, as report::third_octave_velocity
};

/// The budget of one acceleration.
struct SignalBudget {
  std::vector<BudgetPart> sources;  ///< of Budget::sources
  BudgetPart total;
  double scatter = 0;  ///< m/s^2, standard deviation of the rms of one run, by its noises
  std::string vibration_class;
};

struct MethodBudget {
  BudgetMethod method = BudgetMethod::passive;
  std::vector<SignalBudget> axes;
};

/// What moves the frame of a scene, source by source.
struct Budget {
  double sample_rate_hz = 0;
  std::int64_t n_samples = 0;
  std::vector<ComparedFrame> axes;
  std::vector<std::string> sources;
  Eigen::VectorXd edges_hz;  ///< of the cells: 0, from 0.089 Hz on four in a third octave, half the
                             ///< rate
  std::vector<MethodBudget> methods;
  std::vector<SignalBudget> floors;  ///< of the axes, without sources; none where an axis has none
  std::string left_out;  ///< what of the scene is not linear, in one line; empty: nothing

  const MethodBudget* of(BudgetMethod method) const;
};

struct BudgetPlan {
  std::vector<ComparedFrame> axes;            ///< outputs and monitors of the scene, by name
  std::int64_t n_samples = 0;                 ///< measurements of the run, the first at rest
  std::function<void(double)> progress = {};  ///< share of the work, 0 to 1
};

/// The error budget of a scene on a floor, for every way to hold it that its gains have: courses
/// (channels of the floor, forces, offsets and drifts of sensors) through the exact sampled loop in
/// time, noises through it in the mean square. Set-up. Source: docs/decisions/0032-error-budget.md.
/// Errors: InputError for a signal that the scene has not, a floor that turns what the loop has no
/// input for, and as FloorMotion and ForceCourse; Refusal of a loop that is not stable.
Budget error_budget(const LoopDesign& design, const floor::FloorSpec& floor,
                    const BudgetPlan& plan);

}  // namespace stillframe::judge

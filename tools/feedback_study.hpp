#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/control/design/frame_feedback.hpp"
#include "judge/loop_design.hpp"

namespace stillframe::tools {

/// What a feedback does on the whole plant of a scene, as it runs.
struct FeedbackRow {
  std::string method;                  ///< pi, h2, minimax
  std::optional<double> lead_samples;  ///< of a PI
  std::string why_none;                ///< in words, and then nothing below is set
  Index n_states = 0;
  Eigen::VectorXd largest;       ///< singular value of T at the study's frequencies, 1
  double peak = 0, peak_hz = 0;  ///< highest of T anywhere below half the rate
  double disk = 0;               ///< of all legs
  double radius = 0;             ///< spectral radius
  double radius_off = 0;         ///< the largest with forces of 0.75 and 1.25 and a sample later
  double noise = 0;              ///< largest gain of sensor noise to acceleration, m/s^2 per N
  std::string law;               ///< as a file of `law:`; empty of a PI
};

/// Isolation of the stiffest virtual mode against disk margin: the largest T over the target's, dB,
/// from 1.5 targets to to_hz.
struct MarginPoint {
  std::string method;
  double disk = 0;
  double level_db = 0;
  double bound_db = 0;  ///< of minimax: no feedback of its freedom is below; else NaN
};

struct FeedbackStudy {
  double disk = 0, to_hz = 0;      ///< what was asked for
  double stiffest_hz = 0;          ///< virtual mode that the curve is of
  Eigen::VectorXd frequencies_hz;  ///< round ones
  Eigen::VectorXd target;          ///< |T| of the lowest target there
  Eigen::VectorXd passive;         ///< largest singular value of T without control
  std::vector<FeedbackRow> rows;
  std::vector<MarginPoint> curve;  ///< empty unless asked for
};

struct FeedbackWish {
  double disk = 0.5;
  double to_hz = 0;  ///< 0: a twentieth of the rate, at most 20 targets
  bool curve = false;
};

/// Compares the PI of a scene as it is written, the PI with the lead that keeps the wished disk
/// margin, and the feedbacks that are designed on the sampled loop. `now` hears what is done next.
/// Errors: as frame_feedback and make_loop_design.
FeedbackStudy feedback_study(const judge::LoopDesign& design, const FeedbackWish& wish,
                             const std::function<void(const std::string&)>& now);

}  // namespace stillframe::tools

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "controller/rig/probe.hpp"
#include "controller/rig/rig_file.hpp"
#include "controller/rig/wiring.hpp"
#include "core/control/fitting/rig_fit.hpp"
#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// What is asked of a rig that is to be commissioned.
struct CommissionQuestion {
  const judge::LoopDesign& design;
  SceneUncertainty uncertainty;  ///< what the scene is known to, each way, all of it as likely
  double force_n = 0;            ///< peak on a leg
  double window_s = 2;
  int n_windows = 5;
  bool only_wiring = false;  ///< nothing is recorded, and nothing has to be uncertain
};

/// What was found.
struct Commissioned {
  controller::Wiring wiring;  ///< of the rig file as it was
  controller::RigFile rig;    ///< put right, with the gains that were fitted
  controller::Recording recording;
  fitting::FitQuestion question;
  double force_n = 0;         ///< peak of what was recorded
  Eigen::Index n_window = 0;  ///< samples
  std::vector<int> lines;     ///< whole periods in a window, that it was driven at
  Eigen::Index n_late = 0;    ///< commands that acted a sample late, as amplifiers reported
  fitting::RigFit fit;
  Eigen::VectorXd read_back;  ///< m, what is applied over what is commanded
  double disturbance_db = 0;  ///< what is read while driven over what is read at rest, least output
};

/// The lines of a window that a rig is driven at: evenly spaced on a logarithmic axis to 0.42 of
/// the rate, none within 8 % of a resonance of the model, which an undamped frame would follow.
/// Errors: InputError if those are too few to tell anything.
std::vector<int> commission_lines(const judge::LoopDesign& design, Eigen::Index n_window);

/// Errors: InputError where windows of that length are too few, too many or too long to be
/// recorded.
void require_recordable(const judge::LoopDesign& design, double window_s, int n_windows);

/// What is being done, and the part of it that is done.
using Progress = std::function<void(const std::string&, double)>;

/// Probes the wiring, puts right its cables and signs, and gains that are off by more than half:
/// other gains and delays are for the fit, which knows the plant. Then records. io is in the units
/// and on the cables of the driver; rig: of the rig file. To be called by a thread at real-time
/// priority. Errors: std::runtime_error of probe_rig and record_rig, and of channels that give no
/// numbers or stick (require_motion); InputError where the rig's accelerometers are none of the
/// scene's, nothing is uncertain or a window tells nothing. Where the wiring cannot be put right
/// there is no recording, and wiring.connected is false.
Commissioned measure(controller::Io& io, const controller::RigFile& rig,
                     const CommissionQuestion& question, const controller::ProbeTime& time,
                     const Progress& progress, const std::function<bool()>& stop);

/// Whoever stands still, to the bit, through a quarter of a window with a leg driven, and changes
/// at a hundred samples of most others with that leg or of those at rest, is stuck: a fit leaves
/// out the windows in which that happens late, as if there had been a knock. So is an accelerometer
/// of the frame that never moves. Errors: std::runtime_error that names the first one.
void require_motion(const controller::Recording& recording, Eigen::Index n_window,
                    double sample_rate_hz, const std::vector<std::string>& legs,
                    const controller::RigFile& rig);

/// Fits what was recorded, and puts the gains that come out into the channels of the rig, and the
/// tares of its force sensors. Seconds
/// of computing, by a thread of no priority. Errors: as fit_rig.
void fit_recording(Commissioned& found, const Progress& progress);

/// Where each accelerometer of the rig stands among the scene's outputs. Errors: InputError where
/// it is none of them.
std::vector<Eigen::Index> outputs_of(const controller::RigFile& rig, const Scene& scene);

/// The deviation that was found of each parameter (SI, relative, samples) and the standard
/// deviation of it; how far it could be off before, each way.
double known_before(const Commissioned& found, std::size_t parameter);
double found_deviation(const Commissioned& found, std::size_t parameter);
double found_doubt(const Commissioned& found, std::size_t parameter);
/// Whether the rig told it: known better by half than before.
bool is_told(const Commissioned& found, std::size_t parameter);
/// Whether any was.
bool anything_told(const Commissioned& found);
/// q, m/s^2, the largest reading of each accelerometer from its mean at rest, in the recording.
Eigen::VectorXd frame_peak(const Commissioned& found);
/// Those with which it could trade places: correlated by 0.9 or more.
std::vector<std::size_t> alike(const Commissioned& found, std::size_t parameter);

/// What was found as a block `corrections` of the scene, and what is left to doubt as one
/// `uncertainty`: two standard deviations of the least known of each kind.
std::string corrections_block(const Commissioned& found);
std::string uncertainty_left(const Commissioned& found);

}  // namespace stillframe::judge

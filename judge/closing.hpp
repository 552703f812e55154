#pragma once

#include <Eigen/Core>
#include <vector>

#include "controller/rig/closing.hpp"
#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// What a loop makes of a force that is added to its commands, measured on a rig in operation and
/// predicted: the largest singular value of the transfer matrix from the legs to
///   frame    the accelerometers of the frame (m/s^2 per N),
///   sigma    the force sensors (N per N),
///   strain   the force sensors less what is applied (N per N), the force that the legs' stiffness
///            makes. A force feedback answers by a motion that does not depend on that stiffness,
///            but a floor comes through by it: who judges motions alone passes a loop that
///            isolates by half.
struct ClosedResponse {
  enum class Of { frame, sigma, strain };
  Of of = Of::frame;
  Eigen::VectorXd frequencies_hz;                ///< n_f
  Eigen::VectorXd measured, predicted, passive;  ///< n_f; passive: without the law, predicted
  /// n_f, one standard deviation of what the scatter of the windows makes of measured, or more: of
  /// the whole matrix.
  Eigen::VectorXd noise;
  /// n_f, |u^H T v| over the largest singular value of the prediction, u and v its vectors, and one
  /// standard deviation of it. What noise makes of one direction is far less than of a largest
  /// value, and nothing is added by it on the average.
  Eigen::VectorXd along, along_noise;
  /// The predictions between the lines, to be drawn; n_g.
  Eigen::VectorXd axis_hz, predicted_axis, passive_axis;

  /// measured over predicted, and over what it would be without the law.
  double off_db(Eigen::Index line) const;
  double off_passive_db(Eigen::Index line) const;
  /// Two standard deviations of it.
  double doubt_db(Eigen::Index line) const;
  /// Lines that noise leaves within told_db, and those where what the law does is larger than the
  /// limit and noise together, whatever that is: there a loop that did nothing would be seen.
  bool is_told(Eigen::Index line) const { return doubt_db(line) < told_db || tells_law(line); }
  /// The law makes so much of a difference there.
  bool tells_law(Eigen::Index line) const;
  /// The told line that is furthest off; -1: none is told.
  Eigen::Index worst() const;
  Eigen::Index n_told() const;
  /// At how many told lines the law is seen to act: what is measured is not what it would be
  /// without.
  Eigen::Index n_acting() const;
  /// along, in dB, and two standard deviations of it.
  double along_off_db(Eigen::Index line) const;
  double along_doubt_db(Eigen::Index line) const;
  /// The mean of that over all lines, each by what noise leaves of it, and two standard deviations
  /// of it; infinite: noise hides all.
  double mean_off_db() const;
  double mean_doubt_db() const;
  /// Noise leaves the mean within most_db.
  bool is_known() const { return mean_doubt_db() <= most_db; }
  /// The law is seen to act, and nothing is off by more than most_db and what noise may do: no line
  /// that is told, none along the prediction that noise leaves within most_db, and not their mean,
  /// which has to be known.
  bool is_as_predicted() const;

  /// A loop that is a decibel off in its size, a tenth, is well within its margins; a model that
  /// was fitted is a tenth of that.
  static constexpr double told_db = 0.5, most_db = 1;
};

/// N, peak of what is added to the commands of a loop whose rig was driven by force_n before: a
/// fifth less, as the law answers it, and so little that it does so by half of the force limit at
/// most. policy: with the excitation, whatever its force. Errors: as Excitation and force_limit.
double added_force(double force_n, const LoopDesign& design, controller::Policy policy);

/// Of what close_on_rig recorded, by the design whose gains ran: of the frame, without any
/// accelerometer of sigma, and of the strain. frame: of each accelerometer of the recording, the
/// output of the scene.
std::vector<ClosedResponse> closed_responses(const controller::ClosedRecording& run,
                                             const LoopDesign& design,
                                             const std::vector<Eigen::Index>& frame);

/// Whether all of them are.
bool are_as_predicted(const std::vector<ClosedResponse>& responses);

}  // namespace stillframe::judge

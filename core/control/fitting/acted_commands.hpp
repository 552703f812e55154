#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe::fitting {

/// Commands as they acted.
struct ActedCommands {
  Eigen::MatrixXd command;  ///< n x m, N
  Eigen::Index n_late = 0;  ///< samples at which another than their own acted
};

/// The commands of a recording, put right where what amplifiers report shows that one came too late
/// for its sample: the one before acted on then, or the one that was sent before, late itself. A
/// machine that is loaded has one in 1e5 of them, which makes as much noise as all sensors
/// together, and no clock of the host tells it for certain. The way from a command to its report is
/// taken from the record itself, as 16 weights of past commands after a whole delay of up to 40
/// samples, so no model has a part in it; where an amplifier does what no such weights say (a lag
/// of several samples, hysteresis, a resonance) that counts as noise, and late ones are left as
/// they were sent. Only one that clips now and then is mistaken, by some 0.4 % of the commands.
/// command: n x m, N, sent in answer to each sample. applied: n x m, N, as reported with it; a leg
/// with a number that is none is not asked. missing: of each row, whether the sample did not come;
/// empty: all came. The last 60 rows are left as they were sent. Set-up.
ActedCommands acted_commands(const Eigen::MatrixXd& command, const Eigen::MatrixXd& applied,
                             const std::vector<bool>& missing);

}  // namespace stillframe::fitting

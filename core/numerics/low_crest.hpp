#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace stillframe {

/// Schroeder's phases (rad) for a sum of equal lines: the group delay grows by an equal share of
/// the period with every line, so that the lines take turns.
///   phi_{l+1} = phi_l - 2 pi (f_{l+1} - f_l) period (l + 1) / n.
/// Source: M. R. Schroeder, IEEE Trans. Inf. Theory 16 (1970) 85-89, here for uneven spacing.
/// frequencies_hz: ascending. period: s, common to all lines.
Eigen::VectorXd schroeder_phases(const std::vector<double>& frequencies_hz, double period);

/// Phases (rad) that keep the envelope |sum_l exp(j (phi_l + 2 pi f_l t))| low, hence the crest
/// whatever phase is added to all lines together. Schroeder's phases suit evenly spaced lines; for
/// others the envelope is clipped and the phases of the clipped signal taken, over and over, and
/// the best set kept. Source: E. van der Ouderaa, J. Schoukens, J. Renneboog, IEEE Trans. Instrum.
/// Meas. 37 (1988) 145-147. Arguments as above; each frequency a whole multiple of 1 / period.
/// points: of the signal, that are looked at in all rounds together; a million take 0.05 s.
Eigen::VectorXd low_crest_phases(const std::vector<double>& frequencies_hz, double period,
                                 std::size_t points = std::size_t{1} << 25);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>

namespace stillframe::report {

// Windows of n samples, periodic: the sample behind the last would be the first again. Source:
// F. J. Harris, On the use of windows for harmonic analysis with the discrete Fourier transform,
// Proc. IEEE 66 (1978), table 1.

/// Its transform is zero at whole bins but for three.
Eigen::VectorXd hann(Eigen::Index n);

/// Its square: side lobes fall with the fifth power of the distance; its transform is zero at whole
/// bins but for five.
Eigen::VectorXd hann_squared(Eigen::Index n);

/// The share of a tone's power that hann_squared spreads to one side, bins or more away from it: a
/// half at 0, and 2.9e-3, 3.1e-8 and 2.1e-11 at 2, 5 and 11.
double beyond_lobe(double bins);

/// 4-term, side lobes below -92 dB; its transform is zero at whole bins but for seven.
Eigen::VectorXd blackman_harris(Eigen::Index n);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>

namespace stillframe::report {

// Windows of n samples, periodic: the sample behind the last would be the first again. Source:
// F. J. Harris, On the use of windows for harmonic analysis with the discrete Fourier transform,
// Proc. IEEE 66 (1978), table 1.

/// Its transform is zero at whole bins but for three.
Eigen::VectorXd hann(Eigen::Index n);

/// 4-term, side lobes below -92 dB; its transform is zero at whole bins but for seven.
Eigen::VectorXd blackman_harris(Eigen::Index n);

}  // namespace stillframe::report

#pragma once

#include <algorithm>
#include <cstdio>
#include <vector>

#include "bench/large_motion/mechanism.hpp"

namespace stillframe::race {

/// Inputs of a run by the words of a command line: the number of samples, and the amplitude (m/s^2)
/// of sines from 1 to 100 Hz, which may be 0.
inline Eigen::MatrixXd shaking(Eigen::Index inputs, const std::string& samples, double sample_time,
                               const std::string& amplitude) {
  return sines(inputs, std::stol(samples), sample_time, std::stod(amplitude), 1, 100);
}

/// The same run several times, and a line of JSON of it: the median of the processor times,
/// velocities of the outputs at the end, and the root mean square of those after each sample.
template <class MakeRun>
void print_runs(double sample_time, const MakeRun& make_run) {
  std::vector<double> seconds;
  Run run;
  double all = 0;
  while (seconds.size() < 3 || (all < 0.1 && seconds.size() < 50)) {
    run = make_run();
    seconds.push_back(run.seconds);
    all += run.seconds;
  }
  std::nth_element(seconds.begin(), seconds.begin() + static_cast<long>(seconds.size() / 2),
                   seconds.end());
  double squares = 0;
  Eigen::VectorXd v = Eigen::VectorXd::Zero(run.accelerations.rows());
  for (Eigen::Index k = 0; k < run.accelerations.cols(); ++k) {
    v += sample_time * run.accelerations.col(k);
    squares += v.squaredNorm();
  }
  std::printf("{\"seconds\": %.9g, \"rms\": %.17g, \"velocities\": [", seconds[seconds.size() / 2],
              std::sqrt(squares / static_cast<double>(run.accelerations.cols())));
  for (Eigen::Index i = 0; i < v.size(); ++i) std::printf("%s%.17g", i > 0 ? ", " : "", v(i));
  std::printf("]}\n");
}

}  // namespace stillframe::race

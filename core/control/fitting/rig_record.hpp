#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe::fitting {

/// What a rig was told and what it read, m legs, q accelerations of the frame, p of the floor, one
/// row a sample.
struct RigRecord {
  double sample_time = 0;   ///< s, by the clock of the rig
  Eigen::MatrixXd command;  ///< n x m, N, sent in answer to the sample; held where none was
  Eigen::MatrixXd sigma;    ///< n x m, N
  Eigen::MatrixXd applied;  ///< n x m, N
  Eigen::MatrixXd frame;    ///< n x q, m/s^2, mean over the sample that ends there
  Eigen::MatrixXd floor;    ///< n x p, m/s^2, likewise; p 0: not measured
  /// Parts of it that are looked at, n_window samples each from these on; a few samples more stand
  /// before and behind each.
  std::vector<Eigen::Index> windows;
  Eigen::Index n_window = 0;
  /// n, whether the sample did not come, what stands there is of no meaning then; empty: all came.
  std::vector<bool> missing;
  std::vector<int> lines;  ///< whole periods in a window, what commands are made of
};

}  // namespace stillframe::fitting

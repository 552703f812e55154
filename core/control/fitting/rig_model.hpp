#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/control/fitting/rig_record.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::fitting {

/// Where the sums of a window of n samples are taken, z_l = exp((decay + i) w_l), w_l the angle of
/// line l. On the circle (decay 0) they are Fourier sums. Beyond it every mode looks damped by so
/// much more, so that no resonance stands in a fit's way; the end of a window counts little then.
struct LineKernel {
  /// lines: whole periods in a window.
  LineKernel(Eigen::Index n_window, const std::vector<int>& lines, double decay);

  Eigen::VectorXcd z, z_n;  ///< lines; z_n: z^-n
  Eigen::MatrixXcd powers;  ///< n x lines, 2/n z^-k
};

/// The sums of a window, X(l) = 2/n sum_k x[k0 + k] z_l^-k, which of a sampled plant obey, without
/// any window function and however long it still rings:
///   (z I - Phi) X = Gamma_0 C_0 + Gamma_u C_1 + Gamma_w W + z (X_0 - z^-n X_n),
/// X_0, X_n = 2/n x[k0], 2/n x[k0 + n]: unknown real numbers of each window, n_x on the circle,
/// where their difference alone is seen, and 2 n_x beyond it. C_0 and C_1 are the sums of the
/// commands that act in the two parts of a sample.
class WindowData {
 public:
  /// report_age: samples by which what is read of `applied` is late.
  WindowData(const RigRecord& record, Eigen::Index window, int report_age,
             const LineKernel& kernel);

  /// n_out x lines: sigma, applied (as it was when its force was), frame.
  const Eigen::MatrixXcd& read() const { return read_; }
  /// n_out x lines each: what a number in the place of one that did not come adds to the sums.
  std::vector<Eigen::MatrixXcd> gaps() const;
  /// (2 m + p) x lines: C_0, C_1, W of commands that come so many whole samples late (m).
  Eigen::MatrixXcd driven(const Eigen::VectorXi& whole_delay) const;

 private:
  Eigen::VectorXcd commands(Eigen::Index leg, Eigen::Index late) const;

  const RigRecord& record_;
  const LineKernel& kernel_;
  Eigen::Index from_;
  int report_age_;
  Eigen::MatrixXcd read_, floor_, command_;
};

/// What a sampled plant makes of them.
class RigModel {
 public:
  /// frame: the rows of y that are measured.
  RigModel(const SampledPlant& plant, const RigRecord& record,
           const std::vector<Eigen::Index>& frame, const LineKernel& kernel);

  /// What this changes by along a change of its plant: the derivative of the resolvent is taken
  /// from its inverse, and only matrices, which change smoothly, by differences; near a resonance
  /// differences of responses are of no use. above, below: plants a step apart, with these whole
  /// samples of delay.
  RigModel slope(const SampledPlant& above, const SampledPlant& below, double step) const;

  /// Unknown numbers of a window.
  Eigen::Index n_ends() const { return n_ends_; }
  const Eigen::VectorXi& whole_delay() const { return whole_delay_; }
  /// n_out x lines: what is read where the states at the ends add nothing.
  Eigen::MatrixXcd predicted(const WindowData& window) const;
  /// n_out x n_ends at a line: what they add to it.
  Eigen::MatrixXcd of_ends(std::size_t line) const;

 private:
  RigModel() = default;

  Eigen::Index n_ends_ = 0, n_floor_ = 0;
  Eigen::VectorXi whole_delay_;
  std::vector<Eigen::Index> frame_;
  Eigen::VectorXcd z_;
  std::vector<Eigen::MatrixXcd> response_;  ///< of each line, n_out x (2 m + p + n_ends)
  std::vector<Eigen::MatrixXcd> state_;     ///< of each line, n x (2 m + p + n_ends)
};

}  // namespace stillframe::fitting

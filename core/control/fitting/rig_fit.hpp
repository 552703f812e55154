#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <vector>

#include "core/control/fitting/rig_record.hpp"
#include "core/control/robustness/parameters.hpp"

namespace stillframe::fitting {

/// What is fitted, and where it starts.
struct FitQuestion {
  Scene scene;  ///< with a controller
  Sampling sampling;
  /// p; `size` is what each is known to beforehand, one standard deviation.
  std::vector<robustness::Parameter> parameters;
  std::vector<Eigen::Index> frame;  ///< q, outputs of the scene that the record has
};

/// What a leg's own force sensor reads over the force that it is driven by, at the lines, mean over
/// windows, without what still rings from their ends.
struct LegResponse {
  Eigen::VectorXcd measured, fitted, before;  ///< lines, 1; before: of the scene as it is
};

struct RigFit {
  Eigen::VectorXd values;      ///< p, in units of size
  Eigen::MatrixXd covariance;  ///< p x p, in units of size, with what was known beforehand
  /// n_out (sigma, applied, frame), rms over windows and lines of what the fit leaves over that of
  /// what was read, while driven; before: of the scene as it is.
  Eigen::VectorXd left, left_before;
  /// What it leaves while driven, a real number of the whitened sums in the mean square, by the
  /// noise at rest: 1 if that is all. 0 without windows at rest.
  double over_noise = 0;
  std::vector<LegResponse> legs;  ///< m
  /// Windows that were left out, as one thing happened in each that did not in the others: a
  /// knock, say.
  int n_left_out = 0;
  int n_iterations = 0;
  bool converged = false;

  /// Half as much again as the noise at rest is more than few windows of it are wrong by.
  bool is_noise() const { return over_noise < 1.5; }

  double deviation(Eigen::Index i) const { return std::sqrt(covariance(i, i)); }
  double correlation(Eigen::Index i, Eigen::Index j) const {
    return covariance(i, j) / (deviation(i) * deviation(j));
  }
};

/// Fits by least squares what the record says at its lines,
///   min over p and the D_w of   sum |L_l (Y_w(l) - G_l(p) U_w(l) - B_l(p) D_w)|^2 + |p|^2,
/// Y, U, B, D of WindowData. L_l^H L_l is the inverse of the covariance of what is left at lines
/// about l while nothing is driven, and at last, where that explains what is left, of all: noise of
/// the floor comes into all outputs together, along a few directions, and costs little across them.
/// D_w are eliminated. Bands are of that noise: what the model cannot say adds to it, and shows in
/// over_noise. Where it does, but in a few windows far more than in the others, those are left out.
/// driven: of each window, whether commands were on it. Set-up. Errors: InputError,
/// Refusal of a scene that has no such model; std::invalid_argument if the record has too few
/// windows.
RigFit fit_rig(const FitQuestion& question, const RigRecord& record,
               const std::vector<bool>& driven, const std::function<void(double)>& progress = {});

}  // namespace stillframe::fitting

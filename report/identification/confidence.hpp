#pragma once

#include <Eigen/Core>

#include "report/identification/frequency_response.hpp"

namespace stillframe::report {

/// Lower and upper ends of confidence bands, a value each.
struct Bands {
  Eigen::MatrixXd lower, upper;
  /// How much of either side is no chance but what noise of the inputs may have taken off the value
  /// (input_noise_error); empty: nothing.
  Eigen::MatrixXd bias = {};
};

/// The two-sided quantile t of Student's distribution: P(|x| <= t) = level. dof need not be whole.
double student_quantile(double level, double dof);

/// Radii of the circles about the entries of T at one frequency that hold the true entries with
/// probability `level` each, n_y x n_w:
///   |dT_ij|^2 <= C_ii G_jj F,   F = dof ((1 - level)^(-1 / dof) - 1),
/// the quantile of Fisher's distribution with 2 and 2 dof degrees of freedom, which for noise that
/// is circular and Gaussian is exact.
Eigen::MatrixXd entry_radii(const FrequencyResponse& response, Eigen::Index frequency,
                            double level);

/// A band of the magnitude of one entry of T at one frequency that holds the true one with
/// probability `level`. Far above its noise, v = C_ii G_jj, the measured one is real with Gaussian
/// noise of half the power along T_ij, and the half across adds to its square:
///   sqrt(|T_ij|^2 - v / 2) +- t sqrt(v / 2),  t Student's quantile with 2 dof degrees of freedom;
/// within the circle of entry_radii it may as well be zero. For 95 %, any magnitude and 4 degrees
/// of freedom or more that holds in 93.5 to 97.2 % of all cases (test_confidence). (The circle
/// itself, as a band of the magnitude, would be 25 % too wide.)
struct Interval {
  double lower = 0, upper = 0;
};
Interval magnitude_band(const FrequencyResponse& response, Eigen::Index frequency, Eigen::Index i,
                        Eigen::Index j, double level);
/// The same of |T_i a|, the answer of one output to inputs that move together as a: with
/// v = C_ii a' G a.
Interval magnitude_band(const FrequencyResponse& response, Eigen::Index frequency, Eigen::Index i,
                        const Eigen::VectorXd& a, double level);

/// Bands that hold each true singular value with probability `level`, n_f x n_s, not below zero.
/// Singular values are no smooth functions of T where they meet, as those of symmetric frames do in
/// pairs: noise drives such a pair apart, and the smallest ones up. So the bands come from draws:
/// values that noise alone could have driven apart are put at their mean, T is drawn anew with its
/// noise, and the distances of all draws of such a group from that mean are taken off the measured
/// values; one that could be zero has a lower end of zero. What noise of the inputs may have taken
/// off is added on either side. Source: B. Efron, R. J. Tibshirani, An
/// Introduction to the Bootstrap (1993), chapter 13. draws: of each frequency, from a fixed seed.
Bands singular_value_bands(const FrequencyResponse& response, double level, int draws = 1000);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe::report {

/// A frequency response T measured from data, y = T w + noise, from n_w inputs to n_y outputs, and
/// how far it is to be trusted. With the inputs of the equations that T was solved from as the rows
/// of Phi, and noise of covariance C in each of them,
///   E[dT_ij conj(dT_kl)] = C_ik G_jl,   G = (Phi^H Phi)^-1,
/// C estimated with `dof` complex degrees of freedom. n_s = min(n_y, n_w).
struct FrequencyResponse {
  std::vector<double> frequencies_hz;          ///< n_f, Hz
  std::vector<Eigen::MatrixXcd> T;             ///< n_f matrices n_y x n_w, output unit / input unit
  Eigen::MatrixXd singular_values;             ///< n_f x n_s, largest first
  std::vector<Eigen::MatrixXcd> noise;         ///< n_f matrices C, n_y x n_y, Hermitian
  std::vector<Eigen::MatrixXcd> input_weight;  ///< n_f matrices G, n_w x n_w, Hermitian
  /// n_f matrices n_w x n_w: the share S of T that noise of variance 1 in each input of the
  /// equations takes off it, T^ = T (I - S); none where that is in C already, as with known lines.
  std::vector<Eigen::MatrixXcd> unit_noise_share = {};
  std::vector<Eigen::MatrixXcd> input_share = {};  ///< S of the inputs' noise (input_noise.hpp)
  /// n_f matrices n_y x n_y, Hermitian, the mean of y y^H over the equations.
  std::vector<Eigen::MatrixXcd> output_power;
  Eigen::VectorXd dof;  ///< n_f
  /// n_f x n_y, output unit^2 / Hz, one-sided: what the outputs do that the inputs do not explain.
  Eigen::MatrixXd noise_density;
  Eigen::MatrixXd coherence;  ///< n_f x n_y, the share of an output's power that the inputs explain
  /// n_f x n_s, the same of the outputs' part along the left singular vector of each value.
  Eigen::MatrixXd directional_coherence;
  /// n_f, condition number of the inputs: 1 for orthogonal ones, without bound where they cannot be
  /// told apart.
  Eigen::VectorXd input_condition;

  Eigen::Index n_frequencies() const { return static_cast<Eigen::Index>(frequencies_hz.size()); }
};

/// Singular values of every matrix, n_f x min(n_y, n_w), largest first; NaN of one that is not
/// finite. All of one shape.
Eigen::MatrixXd singular_values(const std::vector<Eigen::MatrixXcd>& matrices);

/// Fills singular_values, coherence, directional_coherence and noise_density of a response whose T,
/// noise and output_power are there. density: output unit^2 / Hz, one-sided, of noise of variance 1
/// in each equation.
void complete(FrequencyResponse& response, double density);

/// A response that was identified about a model: what estimators leave of T where it bends, near
/// resonances above all, they leave of the difference to the model alone, which is small where the
/// model is right. residual: of the n_y outputs less what the model makes of the motion that it
/// follows, of the n_w inputs less that motion, and of the outputs themselves, in this order;
/// model: its T at the frequencies, n_y x n_w; density: as in complete(). With d the inputs'
/// difference, y less the model's answer to the inputs is r - model d: answers T = model + (R -
/// model D) with the noise of that, so that an input which is not the motion that the model follows
/// is measured as what it is.
FrequencyResponse about_model(const FrequencyResponse& residual,
                              const std::vector<Eigen::MatrixXcd>& model, double density);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <optional>

#include "report/identification/frequency_response.hpp"

namespace stillframe::report {

/// Noise of the inputs' own sensors is taken for excitation, which no band of what the outputs
/// leave over tells of. With inputs w + n, n of covariance Q, and S_ww the power of w + n in the
/// equations, least squares find
///   T^ = T (I - S),  S = Q S_ww^-1  (errors in variables; W. A. Fuller, Measurement Error Models,
///   1987, chapter 1):
/// T is too small by the share of noise in each direction of the inputs. Two inputs that nearly
/// move together leave a direction, their difference, that may be nothing but noise.
///
/// Fills S (`input_share`) of a response that has `unit_noise_share`. density: unit / sqrt(Hz),
/// one-sided, of white noise that each input is known to carry. Where it is not known no second
/// moment tells it from excitation, but what it may be at most: noise that is alike in all inputs
/// is also, where they are well excited, in the outputs, as motion that the inputs do not explain.
/// With s_k, v_k the eigenvalues and eigenvectors of S, what output i leaves over is
///   C_ii >= q sum_k |T^_i v_k|^2 / (1 - s_k),  s_k = q u_k,
/// u_k those of unit_noise_share; that rises with q, and the q at which an output's whole C_ii
/// would be of this kind is a bound. The least of all outputs is taken. What is estimated here,
/// C_ii or where Q is known S_ww, is taken at its end on the unsafe side, which one record in a
/// thousand goes beyond. rate: Hz.
void find_input_share(FrequencyResponse& response, std::optional<double> density,
                      double sample_rate_hz);

/// A share of noise from which on a direction of the inputs is not excited: 1 - 10^(-1/20), T along
/// it is not known to the 1 dB of ComparisonRule. No singular value is known then, each may have T
/// along that direction in it.
inline constexpr double largest_noise_share = 0.109;

/// How far the singular values of T at one frequency may be off for the noise of its inputs, n_s:
/// those of T^ (I - S)^-1 less those of T^, infinite if a direction is not excited. Zero of
/// a response without `input_share`.
Eigen::VectorXd input_noise_error(const FrequencyResponse& response, Eigen::Index frequency);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/identification/frequency_response.hpp"

namespace stillframe::report {

/// What a broadband identification is to find, and how finely.
struct BroadbandPlan {
  double sample_rate_hz = 0;
  Eigen::Index n_inputs = 0, n_outputs = 0;
  std::vector<double> frequencies_hz;  ///< Hz, above 0 and below half the rate
  /// s, of the stretches that are transformed one by one. The longer, the finer the resolution.
  double segment_s = 64;
  /// Of the whole record, as far as it is known: more segments need fewer bins of each.
  double expected_s = 0;
  /// unit / sqrt(Hz), one-sided density of white noise that each input is known to carry; none: it
  /// is not known (input_noise.hpp).
  std::optional<double> input_noise = {};
};

/// The largest number of samples that may be missing in a row and are put in on the straight line
/// between their neighbours; where more are missing, a new segment begins.
inline constexpr std::int64_t largest_filled_gap = 3;

/// Where filled samples of the inputs may err by so much that this share of T is lost to it, no
/// response is given: 0.09 dB, within the 0.1 dB to which a model is taken to be known
/// (ComparisonRule). What a whole record shows where nothing excites, a lost sample must not.
inline constexpr double largest_filling_share = 0.01;

/// An input whose power in 1 Hz is below this share of its whole power excites nothing there that a
/// converter of 20 bits could tell from its own noise: no response is given.
inline constexpr double least_excitation = 1e-12;

/// Frequency responses from records of any excitation that moves all inputs independently, by the
/// local polynomial method. In a few bins about each frequency f_0 the transforms of a segment obey
///   Y(f) = sum_r T_r (f - f_0)^r W(f) + sum_r t_r (f - f_0)^r + N(f),   r = 0 .. 2,
/// where t is the transient, what the beginning and the end of the segment leave behind: no window
/// is needed and no leakage is left but what a parabola does not follow. t_r belongs to each
/// segment, T_r to all of them. Least squares, orthogonal factors carried from segment to segment,
/// so that memory does not grow with the record; what the equations leave is noise C, with dof
/// equations more than unknowns. Source: R. Pintelon, J. Schoukens, G. Vandersteen, K. Barbe,
/// Mechanical Systems and Signal Processing 24 (2010) 573-595. Set-up.
class LocalPolynomial {
 public:
  /// Errors: std::invalid_argument for a plan that cannot be.
  explicit LocalPolynomial(BroadbandPlan plan);

  /// Takes rows that follow one another, n x n_inputs and n x n_outputs; first_seq is the sample of
  /// the first one, later than those of the calls before. Errors: std::invalid_argument on shapes.
  void add(std::int64_t first_seq, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs);
  /// Takes what the last segment has; nothing can be added after it. If that is all there is, the
  /// bins are as wide as so short a record needs them, up to 2 Hz to either side.
  void finish();

  /// Where there are fewer equations than unknowns and a few more, or no excitation, T is NaN and
  /// dof zero. Errors:
  /// std::logic_error before finish().
  FrequencyResponse estimate() const;

  double half_width_hz() const { return half_width_hz_; }  ///< of the bins about a frequency
  /// Why estimate() knows no T at any frequency; empty if it does. inputs: their names.
  std::string missing(const std::vector<std::string>& inputs) const;
  std::int64_t n_segments() const { return n_segments_; }  ///< used
  std::int64_t n_filled() const { return n_filled_; }      ///< samples in them that were put in
  std::int64_t n_left_out() const { return n_left_out_; }  ///< samples in no segment

 private:
  struct Equations {
    Eigen::MatrixXcd factor;     ///< triangular, of [regressors, outputs]
    Eigen::Index n = 0;          ///< equations, those of the transients taken off
    Eigen::MatrixXcd power;      ///< sum of y y^H over these
    Eigen::VectorXd excitation;  ///< n_inputs, sum of |w|^2 over these
    Eigen::MatrixXd filling;     ///< of regressors: the squares that filled samples may err by
    Eigen::MatrixXd moments;     ///< n_terms x n_terms: of white noise of variance 1 in an input
  };
  void append(const Eigen::RowVectorXd& row);
  void take_segment();
  /// n_inputs x n_inputs: what filled inputs of a segment of n rows may err by in each of its bins.
  Eigen::MatrixXd filling_error(Eigen::Index n) const;
  /// Of T, that errors of filled inputs take off it. Source: W. A. Fuller, Measurement Error Models
  /// (1987), chapter 1.
  double filling_share(const Equations& equations) const;
  Eigen::MatrixXcd unit_noise_share(const Equations& equations) const;  ///< FrequencyResponse
  bool enough(const Equations& equations) const;  ///< more than unknowns, and a few
  Eigen::Array<bool, Eigen::Dynamic, 1> excited(const Equations& equations) const;  ///< inputs
  /// Why at no frequency that has enough equations all inputs are excited.
  std::string at_rest(const std::vector<std::string>& inputs) const;
  double condition_of(const Equations& equations) const;  ///< of the inputs
  void take(Equations& equations, double frequency_hz, const Eigen::MatrixXcd& spectra,
            const Eigen::MatrixXd& filling, double resolution_hz) const;

  BroadbandPlan plan_;
  double half_width_hz_ = 0;
  Eigen::Index length_ = 0;  ///< rows of a whole segment
  Eigen::MatrixXd segment_;  ///< rows of inputs, then outputs; grows to that
  Eigen::Index n_rows_ = 0;  ///< of the segment, so far
  std::int64_t next_seq_ = 0;
  std::vector<Equations> equations_;  ///< one a frequency
  std::int64_t n_segments_ = 0, n_filled_ = 0, n_left_out_ = 0;
  std::int64_t n_longest_ = 0;  ///< rows of the longest stretch
  bool gap_ = false;            ///< a stretch ended before the record did
  struct Gap {
    Eigen::Index first, n;  ///< filled rows of the segment
  };
  std::vector<Gap> gaps_;  ///< of the segment
  std::int64_t n_filled_here_ = 0;
  Eigen::VectorXd input_power_;  ///< n_inputs, sum over segments of the mean square less the mean
  bool finished_ = false;
};

}  // namespace stillframe::report

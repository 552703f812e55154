#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/systems/multisine_plan.hpp"
#include "report/identification/frequency_response.hpp"
#include "report/identification/local_polynomial.hpp"

namespace stillframe::report {

/// Signals of a log by name.
struct ResponseSignals {
  std::vector<std::string> inputs, outputs;
};

/// What was identified from a log, or why nothing was.
struct IdentifiedResponse {
  ResponseSignals signals;
  std::optional<FrequencyResponse> response;
  std::string method;           ///< multisine or broadband
  std::string missing;          ///< why there is no response
  std::int64_t n_filled = 0;    ///< lost samples that were put in
  std::int64_t n_left_out = 0;  ///< samples that belong to no segment
  std::int64_t n_segments = 0;  ///< or steady parts
  double resolution_hz = 0;     ///< half width of what one frequency is made of
};

/// Identifies from samples as they come: by the lines of a plan that is known, or from whatever
/// moves the inputs. Set-up.
class ResponseAnalyser {
 public:
  /// By the plan's lines; memory of the plan's length.
  ResponseAnalyser(ResponseSignals signals, const MultisinePlan& plan);
  /// model: T of the loop that runs at the plan's frequencies, about which is identified; none: it
  /// is not known. further: names of channels of the same floor that are no inputs.
  ResponseAnalyser(ResponseSignals signals, const BroadbandPlan& plan,
                   std::vector<Eigen::MatrixXcd> model = {}, std::vector<std::string> further = {});

  /// Rows that follow one another; seq as LocalPolynomial::add. predicted: what the model makes of
  /// the floor, as outputs, if there is one. strayed: the inputs, and then the further channels,
  /// less the motion of the floor that the model follows; none: they are that motion.
  void add(std::int64_t first_seq, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
           const Eigen::MatrixXd& predicted = {}, const Eigen::MatrixXd& strayed = {});
  IdentifiedResponse finish();

 private:
  struct Lines {
    MultisinePlan plan;
    Eigen::MatrixXd inputs, outputs;  ///< a row a sample of the plan and one before; NaN: missing
  };
  IdentifiedResponse result_;
  std::vector<Eigen::MatrixXcd> model_;
  std::vector<std::string> checked_;  ///< channels that are to be the floor that the model follows
  double density_ = 0;  ///< output unit^2 / Hz, of noise of variance 1 in each equation
  std::optional<double> input_noise_ = {};  ///< BroadbandPlan
  std::variant<Lines, LocalPolynomial> method_;
};

/// dB, of how far an input may be from the motion that the model follows, beyond its band: what a
/// model is taken to be known to (ComparisonRule).
inline constexpr double largest_input_difference_db = 0.1;

/// Inputs of a worse condition than this are not told apart: their response is not shown.
inline constexpr double largest_shown_condition = 1e4;

}  // namespace stillframe::report

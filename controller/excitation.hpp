#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "controller/gains.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// What rigs are driven by where nothing else is asked for: of the force limit, enough for a
/// converter of 12 bits and no danger to anything; and up to that part of the sample rate.
inline constexpr double small_force = 0.02, driven_up_to = 0.42;
/// Periods in a window, from which on; and how many frequencies.
inline constexpr int lowest_line = 2;
inline constexpr std::int64_t usual_lines = ExcitationPlan{}.lines;

/// Whole numbers of periods in a window, evenly spaced on a logarithmic axis between two numbers of
/// them, each once, but for those that are avoided. Set-up.
std::vector<int> logarithmic_lines(double from, double to, int n_lines,
                                   const std::function<bool(int)>& avoid = {});

/// A sum of cosines at these lines over a window, of phases that keep its crest low, of peak 1.
/// Set-up.
Eigen::VectorXd multisine(const std::vector<int>& lines, Eigen::Index n_window);

/// What is added to the law's command while the loop is active, by the plan of the policy. It goes
/// by the numbers of samples, so that one that was lost moves nothing. Construction is set-up; the
/// rest is hot: noexcept, no allocation. Source: docs/safety.md, excitation.
class Excitation {
 public:
  /// Errors: InputError where the plan does not fit the rate or the force limit; Refusal without a
  /// force limit.
  Excitation(const Gains& gains, const Policy& policy);

  bool any() const noexcept { return wave_.size() > 0; }
  /// The law's own force is left out.
  bool open_loop() const noexcept { return open_loop_; }
  /// The loop is active at that sample: the first time it begins there.
  void begin(std::int64_t seq) noexcept {
    if (any() && start_ < 0) start_ = seq;
  }
  /// Where it began; -1: it has not.
  std::int64_t start() const noexcept { return start_; }
  /// From its beginning to its end.
  std::int64_t n_samples() const noexcept { return n_samples_; }
  /// Once it has begun: m, N, in answer to that sample.
  const Eigen::VectorXd& at(std::int64_t seq) noexcept;
  /// m, N, how large that is at most in a window about the sample of at.
  const Eigen::VectorXd& reach() const noexcept { return reach_; }

  Eigen::Index n_window() const noexcept { return wave_.size(); }
  std::int64_t n_windows() const noexcept { return n_windows_; }
  /// Whole periods in a window, of a multisine.
  const std::vector<int>& lines() const noexcept { return lines_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(start_);
  }

 private:
  Eigen::VectorXd wave_;  ///< a window, N
  std::vector<int> lines_;
  std::int64_t n_windows_ = 0, n_samples_ = 0, start_ = -1;
  double peak_ = 0;  ///< N
  bool open_loop_ = false;
  Eigen::VectorXd force_, reach_;  ///< m, N
};

}  // namespace stillframe::controller

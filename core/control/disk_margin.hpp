#pragma once

#include <Eigen/Core>
#include <complex>
#include <optional>
#include <vector>

#include "core/control/loop_settings.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "core/systems/linear_system.hpp"

namespace stillframe {

/// S - I/2 of a loop as one sampled system, S = (I + L)^-1, L the return ratio at the actuators: a
/// force d is added to the force f that acts, but not to what is reported, and the output is
/// f - d/2; m x m, D = I/2. Its poles are those of the closed loop and, of the path of d alone,
/// those of the actuators. Errors: as close_loop.
LinearSystem half_sensitivity(const LoopPlant& plant, const Sampling& sampling,
                              const DiscreteLaw& law);
LinearSystem half_sensitivity(const LoopSettings& settings);

/// A disk margin and the frequency at which it is least. NaN: not known, as a computation failed.
struct DiskMargin {
  double alpha = 0, hz = 0;
};

/// Finds the peaks of S - I/2 over the unit circle. Where they may be narrow is known from the
/// poles of the closed loop: every pole of distance w to the circle is looked at from w/2 on at
/// growing distances on both sides of it, all else on a grid that is even on a logarithmic axis,
/// and what is highest is refined.
class DiskSearch {
 public:
  /// Set-up; the loop is taken to be stable. Errors: as close_loop.
  DiskSearch(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law);
  explicit DiskSearch(const LoopSettings& settings);

  Eigen::Index n_legs() const { return m_; }

  /// 1 / max |S_ii - 1/2|, to 1e-6: a level above the peak that was found is proven to be met
  /// nowhere, by the eigenvalues of the pencil whose angles are those at which it is met, or the
  /// search goes on between them. Source: Bruinsma and Steinbuch, Systems and Control Letters 14
  /// (1990) 287-293, in discrete time.
  DiskMargin of_leg(Eigen::Index leg);

  /// 1 / max mu(S - I/2) by diagonal_mu, for one leg as of_leg. Below `at_least` the search ends
  /// with the first value that shows it, an upper bound of the margin.
  DiskMargin of_all(double at_least = 0);

 private:
  struct Peak {
    double value = 0, angle = 0;
  };

  const Eigen::MatrixXcd& at(double angle);
  double of(Eigen::Index leg, double angle);
  Peak highest(Eigen::Index leg);
  DiskMargin margin(const Peak& peak) const;

  LinearSystem system_;
  FrequencySweep sweep_;
  Eigen::Index m_;
  double sample_time_;
  std::vector<double> angles_;            ///< of z on the upper half of the circle, ascending
  std::vector<Eigen::MatrixXcd> values_;  ///< S - I/2 there
  Eigen::MatrixXcd here_;
};

/// Upper bound of the structured singular value of Z (m x m) for m complex scalars: the 2-norm of
/// D Z D^-1, no more than that of Z, at the least over positive diagonal D that a descent finds.
double diagonal_mu(const Eigen::MatrixXcd& Z);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/control/discrete_law.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// A loop with a delay c of some of its legs, and how far about c it is proven to be stable. As
/// long as no delay passes a whole sample, that at c + d has a pole at z where
///   det(I - H(z) G(d)) = 0,   H(z) = C (z I - A(c))^-1 P,
/// G(d) what d changes of what the command held before does in a sample, C the difference of that
/// command and the next, P into the states of the plant. No pole comes out where that vanishes
/// nowhere on the circle: there the norm of H G is below 1, but in discs about the poles next to
/// it, in which the one pole is followed, to the second order with a bound of all higher ones; a
/// bound alone would not tell a pole that moves along the circle or inwards from one that leaves.
class DelayCentre {
 public:
  /// plant: without exogenous states; sampling: at c, with leg_delays; legs: those that get later.
  /// Set-up. Errors: as close_loop and FrequencySweep.
  DelayCentre(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law,
              const std::vector<Eigen::Index>& legs);

  /// Whether the loop is stable at c; if not there is no more to ask.
  bool stable() const { return stable_; }

  /// Samples before and after c within which it is stable, looked at up to `half` on either side in
  /// `n_steps` (two at least), in each of which no mode of the plant that matters may turn by much.
  struct Reach {
    double before = 0, after = 0;
  };
  Reach reach(double half, int n_steps) const;

 private:
  using Changes = std::vector<Eigen::MatrixXcd>;  ///< G at so many steps, n x legs each
  /// A pole p next to the circle, H = R / (z - p) + H_0 + ... within `width` of it.
  struct Followed {
    std::complex<double> pole;
    double width = 0;
    Eigen::MatrixXcd R, H_0;
    std::vector<std::complex<double>> around;  ///< z - p of points at `width` from it
    std::vector<Eigen::MatrixXcd> H_around;
  };

  StateSpace transposed_system(const DiscreteLaw& law);
  void choose_followed();
  void follow(std::complex<double> pole, double width);
  void walk_round();
  void add_point(double angle);
  void changes(double half, int n, Changes& before, Changes& after) const;
  void on_circle(const Changes& changes, int& reached) const;
  static void in_disc(const Followed& about, const Changes& changes, int& reached);

  const LoopPlant& plant_;
  Sampling sampling_;
  std::vector<Eigen::Index> legs_;
  double queue_turn_ = 1;        ///< rad, over which what waits in queues turns by one
  Eigen::MatrixXcd transposed_;  ///< work: H^T at one z
  FrequencySweep sweep_;         ///< H^T, which has fewer inputs than H
  bool stable_ = false;
  std::vector<Followed> followed_;
  std::vector<Eigen::MatrixXcd> H_;  ///< on the circle, outside the discs
};

}  // namespace stillframe

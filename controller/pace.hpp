#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "controller/designed_loop.hpp"
#include "controller/gains.hpp"
#include "controller/pace_scale.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe::controller {

/// How fast the forces of a loop that is as designed change: what the floor that is measured asks
/// of it, what the noise of its sensors does, and what a frame asks that swung freely before. A
/// loop that wants more has a broken sensor, actuator or cable, whatever else it looks like. Of leg
/// i and a sample:
///   most_i = min(max(F_i + G_i, |c_i| + F_i / 4), |c_i| + min(F_i / 4, 2 C_i) + D_i)
///            + 9 (sum_k (N_ik v_k)^2)^1/2 + 2 S_i + sum_k B_ik d_k
///            + sum_k R_ik f_k + sum_k X_ik e_k + free,
///   F_i = sum_j L_ij W_j.
/// c: what the designed loop, which is followed sample by sample with as much of each command
/// acting as the read-backs say, changes its command by now, but for what a gain that comes up or
/// goes down changes by itself; L_ij: the sum of |change of its command i| after one sample of unit
/// acceleration of the floor, until it no longer swings, so that no floor with |w_j| <= W_j makes
/// it meet F, but one that is accelerated one way for as long as the leak remembers; W_j the
/// largest |w_j|, forgotten within seconds; G_i: the largest |c_i| since more samples in a row were
/// lost than the designed loop follows, for as long as it swings; D_i: what samples of the floor
/// that were lost or not believed may still do; N_ik: the root of the sum of squares after a unit
/// reading of sensor k; v_k its noise, from the fourth differences of what it reads while arming;
/// S_i the largest change of its reading then; B_ik: the largest change while the gain comes up
/// with sensor k constantly off by one, d_k the doubt about its offset, no more of it than the
/// force limit could hold; C_i the largest |c_i| of the last seconds; S_i and d_k are forgotten
/// within seconds, too. The same holds of what a loop changes within some milliseconds, every
/// change remembered for so long (pace_scale.hpp): what grows slowly is seen there. f_k: the force
/// |u_k| from which the gain began to go down, forgotten within seconds, and R_ik the largest
/// change then with leg k holding one newton because of a sensor that is constantly off; e_k the
/// excitation of leg k, forgotten within seconds, and X_ik as L_ij after one newton of it for a
/// sample. Where the
/// floor is not measured, S_i counts four times and is kept. Construction is set-up; the rest is
/// hot: noexcept, no allocation. Source: docs/safety.md.
class Pace {
 public:
  struct Settings {
    double free = 0;  ///< N a sample, that is always allowed
    /// m/s^2: but no more of `free` than F_i of a floor of this acceleration.
    double beside = infinity;
    double ramp_in_s = 1;           ///< s, in which the gain comes up
    double ramp_out_s = 1;          ///< s, in which it goes down
    double force_limit = infinity;  ///< N
    bool excited = false;           ///< excite will be called
  };
  /// Errors: as law_from_gains and sample_and_hold.
  Pace(const Gains& gains, const Settings& settings);

  /// Arming begins: what was learned is forgotten.
  void restart() noexcept;
  /// A measurement with the loop open: sample seq and sigma (m, N).
  void listen(std::int64_t seq, const Eigen::Ref<const Eigen::VectorXd>& sigma) noexcept;
  /// The loop is closed; doubt: m, N, by which the offsets that were taken out may be wrong.
  void begin(const Eigen::Ref<const Eigen::VectorXd>& doubt) noexcept;
  /// After begin: the feed-forward of the law that runs has heard the floor before.
  void hear_as(const Law& law) noexcept { designed_.hear_as(law); }
  /// After begin: the leg whose sensor was broken while arming, by its noise: of that alone the
  /// loop would make larger forces than the legs had, and it is ten times that of the middle one of
  /// all sensors. -1: none.
  Eigen::Index noisy() noexcept;
  /// So many periods have passed.
  void forget(std::int64_t n_elapsed) noexcept;
  /// The floor (p, m/s^2; empty: not measured) as a measurement has it. One sample alone is not
  /// believed, and what its sensors read all the time is no motion. broken: one of its sensors is.
  /// Then it is taken to move as much as it did before, and the designed loop is not followed.
  void floor(const Eigen::Ref<const Eigen::VectorXd>& w, bool broken = false) noexcept;
  /// The law has answered that measurement, n samples after the one before; its force is commanded
  /// times gain, with that share of its feed-forward, and of a command that part acts (m, 1:
  /// Obedience::acts).
  void expect(std::int64_t n, double gain, const Eigen::Ref<const Eigen::VectorXd>& acts,
              double share = 1) noexcept;
  /// So much is added to the commands at most, m, N.
  void excite(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept;
  /// The gain begins to go down from that force (m, N).
  void let_go(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept;
  /// The loop is not where the designed one is: it met a limit of its actuators, or was let go of.
  void lose_track() noexcept;
  /// The largest change of each force now (m, N) from the last command, n samples ago; infinite
  /// where too few samples came one after the other while arming.
  const Eigen::VectorXd& most(std::int64_t n) noexcept;
  /// n samples after its last force, the law asks for one that differs by that much (m, N; not what
  /// it could not get before, nor what the gain changes by itself, which is no haste of the loop's:
  /// a stop lets go of a force that was held in half a second or so). The leg that is furthest
  /// beyond what it may, in this or within some milliseconds; -1: none.
  Eigen::Index command(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& change) noexcept;

  /// m, N: what a command may always change by.
  const Eigen::VectorXd& free() const noexcept { return free_; }

  /// L (m x p, N per m/s^2) and the squares of N (m x m, 1) above.
  const Eigen::MatrixXd& per_floor() const noexcept { return scales_.front().per_floor(); }
  const Eigen::MatrixXd& per_noise() const noexcept { return scales_.front().per_noise(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive(rest_), archive(n_rest_), archive(largest_), archive(before_), archive(believed_),
        archive(last_), archive(squares_);
    archive(smallest_), archive(fourth_), archive(products_), archive(mean_), archive(moved_);
    archive(seq_), archive(n_in_row_), archive(n_squares_);
    archive(floor_known_), archive(whole_), archive(blind_);
    for (PaceScale& scale : scales_) scale.visit(archive);
    designed_.visit(archive);
  }

 private:
  bool knows_noise() const noexcept;
  const Eigen::VectorXd* known_floor() const noexcept { return floor_known_ ? &largest_ : nullptr; }

  DesignedLoop designed_;
  std::vector<PaceScale> scales_;       ///< the first: of single changes
  double keep_, rests_;                 ///< what a sample leaves of W, and adds of w to rest_
  Eigen::VectorXd rest_;                ///< p, m/s^2, what the floor's sensors read at rest
  Eigen::VectorXd largest_, before_;    ///< p, m/s^2, W and the last |w|
  Eigen::VectorXd moves_;               ///< p, m/s^2, the floor without that
  Eigen::VectorXd believed_;            ///< p, m/s^2, the floor as far as it is believed
  Eigen::VectorXd doubted_, beyond_;    ///< p, m/s^2, its change, and what was not believed
  Eigen::MatrixXd last_;                ///< m x 5, the last readings, a ring
  Eigen::VectorXd squares_, smallest_;  ///< m, N^2 and N, of fourth differences and of steps
  Eigen::VectorXd fourth_, products_;   ///< m, N and N^2, the last one, and of two in a row
  Eigen::VectorXd mean_, moved_;        ///< m, N and N^2, of the readings and their sum of squares
  Eigen::VectorXd most_doubt_;          ///< m, N, offsets that would meet the force limit
  Eigen::VectorXd free_;                ///< m, N
  Eigen::MatrixXd force_per_noise_;  ///< m x m, 1, the sum of squares of leg forces after a reading
  Eigen::VectorXd most_, change_, quiet_, variance_, sorted_;
  std::int64_t n_rest_ = 0, seq_ = -1, n_in_row_ = 0, n_squares_ = 0;
  bool floor_known_ = false, whole_ = false, blind_ = false;
};

}  // namespace stillframe::controller

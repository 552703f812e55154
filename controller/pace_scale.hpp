#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace stillframe::controller {

/// What a sound loop does within some time: the changes of its commands, each remembered for so
/// long, z[k] = a z[k-1] + change[k]; a = 0: the change alone. All is linear in what makes the
/// changes, so that of leg i
///   |z_i| <= min(max(F_i + G_i, |c_i| + q F_i), |c_i| + min(q F_i, 2 C_i) + D_i)
///            + sure (sum_k N2_ik v_k^2)^1/2 + 2 S_i + (B d)_i + (R f)_i + (X e)_i + free / (1 -
///            a),
///   F = L W,
/// with L, N2, B, R, X, D and S as in pace.hpp, of z in place of the change, c the z of the
/// designed loop, C the largest |c| of the last seconds, and G the largest |c| since more samples
/// in a row were lost than the designed loop follows, as far as it remembers it. F is of a loop
/// that hears every sample; one that misses some catches up with more, as the designed one does,
/// which misses the same. Set-up: construction, both learn and allow; the rest is hot: noexcept, no
/// allocation.
class PaceScale {
 public:
  /// m legs, p channels of the floor; keep: a.
  PaceScale(Eigen::Index m, Eigen::Index p, double keep);

  /// The changes (m x n, N) of the designed loop's commands after one sample of floor channel j, or
  /// of sensor j - p.
  void learn(const Eigen::Ref<const Eigen::MatrixXd>& changes, Eigen::Index j);

  /// The same after one sample of one newton of excitation on leg j.
  void learn_excitation(const Eigen::Ref<const Eigen::MatrixXd>& changes, Eigen::Index j);
  /// The same, while the gain comes up, with a reading of sensor k that is constantly wrong by one.
  void learn_offset(const Eigen::Ref<const Eigen::MatrixXd>& changes, Eigen::Index k);
  /// The same, while the gain goes down again, of a loop that held so much with that leg (N)
  /// because of such a reading; kept: what a sample leaves of what is forgotten within seconds.
  void learn_letting_go(const Eigen::Ref<const Eigen::MatrixXd>& changes, Eigen::Index k,
                        double held, double kept);
  /// free: m, N a sample, that is always allowed.
  void allow(const Eigen::Ref<const Eigen::VectorXd>& free) { free_ = free / (1 - keep_); }

  /// Arming begins.
  void restart() noexcept;
  /// While arming, the change of what the sensors read (m, N); first: none came before it.
  void listen(const Eigen::Ref<const Eigen::VectorXd>& change, bool first) noexcept;
  /// The loop is closed. doubt: m, N; variance: m, N^2, of the noise of the sensors.
  void begin(const Eigen::Ref<const Eigen::VectorXd>& doubt,
             const Eigen::Ref<const Eigen::VectorXd>& variance) noexcept;
  /// Of what passes within seconds so much is left, after n samples. whole: with the whole gain the
  /// loop has soon forgotten how its frame swung.
  void forget(double kept, std::int64_t n, bool whole, bool floor_known) noexcept;
  /// n samples after the command before, the designed loop has changed its own (m, N).
  void expect(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& change) noexcept;
  /// The gain begins to go down from a force (m, N), of which a part may be held against nothing
  /// that the designed loop knows of: a sensor that has drifted. That goes faster than the gain
  /// does.
  void let_go(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept;
  /// So much (m, N) is added to commands at most, and is answered for seconds.
  void excite(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept;
  /// Of the floor so much (p, m/s^2) was lost or not believed for a sample.
  void doubt_floor(const Eigen::Ref<const Eigen::VectorXd>& w) noexcept;
  /// The loop is not where the designed one is. largest: p, m/s^2, W.
  void lose_track(const Eigen::Ref<const Eigen::VectorXd>& largest) noexcept;
  /// The bound of leg i; largest: p, m/s^2, W, none where the floor is not known; n: samples, whose
  /// changes are made at once.
  double most(Eigen::Index i, const Eigen::VectorXd* largest, double n = 1) const noexcept;
  /// n samples after the command before, it was changed by that much (m, N).
  void command(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& change) noexcept;
  /// The z of leg i over its bound; largest: p, m/s^2, W.
  double part(Eigen::Index i, const Eigen::VectorXd& largest) const noexcept {
    return std::abs(force_(i)) / most(i, &largest);
  }

  /// L (m x p, N per m/s^2) and N2 (m x m, 1).
  const Eigen::MatrixXd& per_floor() const noexcept { return per_floor_; }
  const Eigen::MatrixXd& per_noise() const noexcept { return per_noise_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(reading_), archive(swing_), archive(doubt_), archive(held_), archive(excited_),
        archive(noise_), archive(designed_);
    archive(lost_), archive(caught_up_), archive(met_), archive(force_);
  }

 private:
  /// z of changes.
  Eigen::MatrixXd remembered(Eigen::MatrixXd changes) const;

  double keep_;
  Eigen::VectorXd free_;  ///< m, N
  Eigen::MatrixXd per_floor_, per_noise_, per_offset_, per_held_, per_excited_;
  /// m x p, N per m/s^2: after one sample of the floor z is never more than this, and k samples
  /// later no more than keep_lost_^k of it.
  Eigen::MatrixXd per_lost_;
  double keep_lost_ = 0;
  Eigen::VectorXd reading_;    ///< m, N, z of what the sensors read while arming
  Eigen::VectorXd swing_;      ///< m, N, S
  Eigen::VectorXd doubt_;      ///< m, N, B d
  Eigen::VectorXd held_;       ///< m, N, R f
  Eigen::VectorXd excited_;    ///< m, N, X e
  Eigen::VectorXd noise_;      ///< m, N
  Eigen::VectorXd designed_;   ///< m, N, c
  Eigen::VectorXd met_;        ///< m, N, the largest |c| of the last seconds
  Eigen::VectorXd lost_;       ///< m, N, D
  Eigen::VectorXd caught_up_;  ///< m, N, G
  Eigen::VectorXd force_;      ///< m, N, z of what is commanded
};

}  // namespace stillframe::controller

#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/gains.hpp"
#include "controller/law.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::controller {

/// rad/s, a tenth of the lowest target (of 1 Hz where none is known): where a floor is slower its
/// points move as one, and the loop follows it; what is integrated from further below is of how its
/// sensors drift.
double floor_corner(const Gains& gains);

/// The loop as it was designed, frame and law, sample by sample under the floor that is measured:
/// what a sound loop would command now. Its frame begins at rest. Where the floor acts by its
/// position, too, that is of what it does above a tenth of the lowest target. Construction is
/// set-up; the rest is hot: noexcept, no allocation.
class DesignedLoop {
 public:
  /// Samples that it goes through at most at once.
  static constexpr std::int64_t longest_step = 20;

  /// Errors: as law_from_gains and sample_and_hold.
  explicit DesignedLoop(const Gains& gains);

  /// Back to rest, with that gain of the law in the last command.
  void reset(double gain = 0) noexcept;
  /// Its feed-forward has heard what that of this law has.
  void hear_as(const Law& law) noexcept { law_.hear_as(law); }
  /// Of a command this part acts and is reported, leg by leg (m, 1); at first all of it. Actuators
  /// that are a little short leave legs some of their stiffness, and a frame swings otherwise.
  void actuators(const Eigen::Ref<const Eigen::VectorXd>& part) noexcept { acts_ = part; }
  /// What acts on the frame in the next step beside its own commands, and is not reported: m, N.
  void act_beside(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept { beside_ = force; }
  /// That much (m, N) is added to the next command, and reported.
  void excite(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept { excited_ = force; }
  /// The next command after n samples, of which the last had the floor's acceleration w (p, m/s^2),
  /// those between the one before and it what lies between; commands were held meanwhile. v: m, N,
  /// beside what the sensors read; gain: of the law in the command; share: of the feed-forward in
  /// the law. Returns the change of the command but for what a gain that moves, or an excitation,
  /// changes by itself, m, N. A loop that has run away, as none that is stable does, begins again
  /// at rest.
  const Eigen::VectorXd& step(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& w,
                              const Eigen::Ref<const Eigen::VectorXd>& v, double gain,
                              double share = 1) noexcept;

  Eigen::Index n_floor() const noexcept { return plant_.Gamma_w.cols(); }

  template <class Archive>
  void visit(Archive& archive) {
    archive(x_), archive(w_), archive(before_), archive(commands_), archive(reports_);
    archive(newest_command_), archive(newest_report_), archive(gain_);
    law_.visit(archive);
  }

  /// The last command, m, N.
  auto command() const noexcept { return commands_.col(newest_command_); }
  /// What the sensors read in the last step (m, N), v included.
  const Eigen::VectorXd& sigma() const noexcept { return sigma_; }

 private:
  void sample(const Eigen::Ref<const Eigen::VectorXd>& w) noexcept;
  void push(const Eigen::VectorXd& command) noexcept;

  SampledPlant plant_;
  Eigen::MatrixXd Gamma_beside_;  ///< of a force that acts over a whole sample
  Law law_;
  Eigen::VectorXd x_, x_next_;                ///< of the plant
  Eigen::VectorXd w_, w_now_;                 ///< p, the last floor, and the one of a sample
  Eigen::VectorXd before_, u_, last_;         ///< m, N
  Eigen::VectorXd beside_;                    ///< m, N
  Eigen::VectorXd excited_, excited_before_;  ///< m, N
  Eigen::VectorXd acts_;                      ///< m, 1
  Eigen::VectorXd sigma_, change_;            ///< m, N
  Eigen::MatrixXd commands_;                  ///< m x (whole delay + 1), a ring
  Eigen::MatrixXd reports_;                   ///< m x (report age + 1), a ring
  Eigen::Index newest_command_ = 0, newest_report_ = 0;
  double gain_ = 0;  ///< in the last command
};

}  // namespace stillframe::controller

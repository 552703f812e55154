#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::controller {

/// What the sensors read at one instant, for m legs, p accelerations of the floor and q of the
/// frame.
struct Measurement {
  std::int64_t seq = 0;          ///< number of the sample, rising
  std::int64_t time_ns = 0;      ///< of the sample, from the start of the run
  std::int64_t received_ns = 0;  ///< CLOCK_MONOTONIC, when it came
  Eigen::VectorXd sigma;         ///< m, N, tension positive
  Eigen::VectorXd applied;       ///< m, N, sigma_a really applied when sigma was sampled
  /// p, m/s^2, prescribed accelerations, mean over the sample that ends now; empty: not measured.
  Eigen::VectorXd floor;
  /// q, m/s^2, accelerations of the frame, likewise. The law does not hear them.
  Eigen::VectorXd frame;
  /// false: the force is not this controller's; amplifiers that heard nothing let go, or another
  /// commands. True where an Io cannot tell: then a fade goes on where they have let go.
  bool heard = true;
};

/// The piezo forces that are wanted.
struct Command {
  std::int64_t seq = 0;      ///< of the measurement that it answers; later if there was none
  std::int64_t time_ns = 0;  ///< of that sample
  Eigen::VectorXd force;     ///< m, N, tension positive, after all limits
  bool saturated = false;    ///< true if any force was limited
};

/// All zero, with their sizes. Set-up.
inline Measurement measurement_of(Eigen::Index m, Eigen::Index p, Eigen::Index q = 0) {
  return {.sigma = Eigen::VectorXd::Zero(m),
          .applied = Eigen::VectorXd::Zero(m),
          .floor = Eigen::VectorXd::Zero(p),
          .frame = Eigen::VectorXd::Zero(q)};
}
inline Command command_of(Eigen::Index m) { return {.force = Eigen::VectorXd::Zero(m)}; }

/// How an Io is, for the host around the loop.
struct IoState {
  std::int64_t n_bad = 0;      ///< what came and was no measurement, or found no room
  std::int64_t n_dropped = 0;  ///< commands that did not get away
  /// Since when (CLOCK_MONOTONIC, ns) another controller has commanded; 0: none does.
  std::int64_t obeys_another_since_ns = 0;
  bool failed = false;  ///< it will give no measurement any more
};

/// The way of the loop to its sensors and actuators. All but state is hot: called once or more a
/// period from the loop's thread, it neither waits, allocates nor throws.
class Io {
 public:
  virtual ~Io() = default;

  /// Takes the oldest measurement that has come and was not taken yet; false if there is none.
  /// The vectors have their size already.
  virtual bool receive(Measurement& measurement) noexcept = 0;

  /// Gives a command on its way.
  virtual void send(const Command& command) noexcept = 0;

  /// Called once a period, with a command or without: while it comes, the loop is alive.
  virtual void beat() noexcept {}

  /// On before the first command of a force; off when none is commanded any more and amplifiers
  /// that held one have let go of it.
  virtual void enable(bool) noexcept {}

  /// From any thread.
  virtual IoState state() const noexcept { return {}; }
};

}  // namespace stillframe::controller

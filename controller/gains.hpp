#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/control/discrete_law.hpp"
#include "core/control/feed_forward.hpp"
#include "core/control/own_law.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::controller {

/// The word that stands for a realisation in a gains file.
std::string_view to_text(Realisation realisation);

/// The passive plant as the legs see it, n states z, m legs, u the leg forces sigma_a (N), w the p
/// accelerations of the floor (m/s^2), v and x its velocities and positions:
///   dz/dt = A z + B u + B_w w + A_w (v, x),   sigma = C z + C_w (v, x) + u.
/// A: n x n, B: n x m, C: m x n (N per unit of state), B_w: n x p; without columns where what the
/// floor does to the legs is not known. A_w: n x 2 p, C_w: m x 2 p; both without columns where its
/// acceleration alone does it: not where a frame leans with its weight when its supports move
/// apart, or has more legs than motions.
struct PassivePlant {
  Eigen::MatrixXd A, B, C, B_w, A_w = {}, C_w = {};
};

/// The feed-forward of a gains file, and the names of the accelerations that it hears, p: those of
/// the measurement, which are the columns of PassivePlant::B_w.
struct FloorFeedForward {
  std::vector<std::string> floor;
  FeedForward filter;
};

/// A law that a gains file brings, and the names of all accelerations of the floor in the
/// measurement, as in FloorFeedForward; empty where it hears none.
struct BroughtLaw {
  NamedLaw matrices;
  std::vector<std::string> floor = {};
};

/// The contents of a gains file: all that the controller needs to know of a design, for m legs.
struct Gains {
  std::string scene_hash;         ///< of the scene that the gains were designed for
  std::vector<std::string> legs;  ///< m names, in the order of sigma
  double sample_rate_hz = 0;
  double delay_samples = 1;  ///< a command from sample k takes effect at k + delay_samples
  /// Hz, what the gains aim at, one or one a virtual mode; empty: unknown. The law does not use it.
  std::vector<double> target_hz;
  Realisation realisation = Realisation::implicit_feedthrough;
  double leak_hz = 0;                   ///< w_l / 2 pi
  double high_pass_hz = 0;              ///< w_h / 2 pi
  double lead_samples = 0;              ///< the law acts on e predicted so far ahead, >= 0
  std::optional<double> roll_off_hz;    ///< corner of a first-order low-pass after the law
  std::optional<double> force_limit_n;  ///< N, the largest force of every leg
  Eigen::MatrixXd K_P;                  ///< m x m, 1
  Eigen::MatrixXd K_I;                  ///< m x m, 1/s
  FloorFeedForward feed_forward = {};   ///< empty: none
  /// What runs in place of the PI and the feed-forward. K_P and K_I are then what it is held
  /// against, the PI that target_hz asks for.
  std::optional<BroughtLaw> law = {};
  Instruments instruments;
  PassivePlant plant;
  bool plant_is_as_designed = false;  ///< read from a file whose hash of the plant is right

  Eigen::Index n_legs() const { return static_cast<Eigen::Index>(legs.size()); }
  /// Names of the accelerations of the floor that the law hears, with all others of the
  /// measurement; empty: it hears none.
  const std::vector<std::string>& heard_floor() const;
  /// From here on the law is deaf to the floor.
  void forget_floor();
  double sample_time() const { return 1.0 / sample_rate_hz; }  ///< s
  ForceFeedback feedback() const;
  LawSampling law_sampling() const;
  Sampling sampling() const;
  /// What the loop is closed around: no floor and no outputs, which stability does not ask for.
  LoopPlant feedback_plant() const;
  /// The same with its floor; y: what the force sensors read. Velocities and positions of the floor
  /// are its accelerations integrated, each time behind a high-pass of first order at `corner`
  /// (rad/s).
  LoopPlant loop_plant(double corner = 0) const;
};

/// More states of a loop take minutes to be judged, the time being their cube.
inline constexpr Eigen::Index largest_loop = 400;

/// Accelerations of a floor: for each the loop is followed when a controller starts.
inline constexpr Eigen::Index most_floor_channels = 64;

/// States of the sampled loop that gains are judged by, at most: plant, law, instruments, and what
/// is under way.
Eigen::Index most_loop_states(const Gains& gains);

/// Of the legs, the scene's hash and the matrices of the plant: 16 hexadecimal digits.
std::string plant_hash(const Gains& gains);

/// Reads a gains file. Errors: InputError (missing file, unknown or missing key, size, not finite).
Gains read_gains(const std::filesystem::path& path);

/// Reads gains from text; source_name stands for the file in messages. Errors: InputError.
Gains parse_gains(const std::string& text, const std::string& source_name);

/// Writes gains as YAML with 17 significant digits, so that parse_gains gives back the same bits.
std::string to_yaml(const Gains& gains);

}  // namespace stillframe::controller

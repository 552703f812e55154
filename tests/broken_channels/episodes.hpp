#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "controller/gains.hpp"
#include "controller/policy.hpp"
#include "tests/broken_channels/broken_channels.hpp"

namespace stillframe::controller {

class Rig;

/// The gains of a scene of config/scenes, metrology_frame or the same frame under its weight, with
/// another of the shipped controllers, its legs damped (1000 N s/m, 1 % in the fastest mode), so
/// that the passive frame is no easy comparison.
Gains shipped_gains(const std::string& controller, const std::string& scene = "metrology_frame");

/// What came of one or two things that broke in an active loop.
struct Episode {
  /// From the damage on, over those of the passive frame in the same samples of the same floor: of
  /// the leg forces, and of the accelerations of the frame.
  double peak = 0, acceleration = 0;
  double found_s = -1;  ///< from the damage to the fault; -1: none
  Fault fault = Fault::none;
  bool latched = false;
  bool named = false;  ///< the leg that the controller names is one of those that broke
};

/// When the controller learns that something broke: when its own watch finds it, or, as no real one
/// can, at once; then it holds its forces and lets them go.
enum class Told { by_its_watch, at_once };

/// m/s^2: the frame of config/ left alone has leg forces of some newtons on it.
inline constexpr double usual_floor = 5e-3;

/// The frame left alone on the floor of one seed. Nothing that breaks changes what it does: it is
/// computed once for all episodes on that floor, as far as the longest of them goes.
class LeftAlone {
 public:
  LeftAlone(const Gains& gains, std::uint64_t seed, double floor_size = usual_floor);
  ~LeftAlone();

  std::uint64_t seed() const { return seed_; }
  double floor_size() const { return floor_size_; }
  /// Peaks of leg forces and of accelerations in the samples [begin, end).
  std::pair<double, double> peaks(std::int64_t begin, std::int64_t end);

 private:
  std::uint64_t seed_;
  double floor_size_;
  std::unique_ptr<Rig> rig_;
  std::vector<std::pair<double, double>> samples_;
};

/// Lets a loop become active on a floor of that size (m/s^2) with 1 mN of sensor
/// noise, breaks what is to break (nothing: how it goes without) and looks on for four seconds.
/// Legs, moment and noise by seed. n_lost: from the damage on the first so many measurements of
/// each second are lost. alone: of these gains, and of this floor if it is to be used again; of a
/// floor with another seed or size it is made anew. Source: docs/safety.md.
Episode run_episode(const Gains& gains, const Policy& policy, const std::vector<Broken>& broken,
                    std::uint64_t seed, Told told = Told::by_its_watch,
                    double floor_size = usual_floor, int n_lost = 0,
                    std::optional<LeftAlone>* alone = nullptr);

}  // namespace stillframe::controller

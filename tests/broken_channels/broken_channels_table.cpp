#include <algorithm>
#include <cstdio>
#include <iostream>

#include "core/cli/command.hpp"
#include "core/numerics/worst.hpp"
#include "tests/broken_channels/episodes.hpp"
#include "tests/broken_channels/lying_floor.hpp"

// The table of docs/safety.md: what breaks, how hard the frame is driven, when it is found.
namespace {

using namespace stillframe;
using namespace stillframe::controller;

struct Cell {
  double before = 0, peak = 0, acceleration = 0, found_s = -1, known = 0, known_acceleration = 0;
  int n_naming = 0, n_named = 0;
};

Cell cell(const Gains& gains, const std::vector<Broken>& broken, int n_seeds, double floor) {
  Policy free;
  free.free_rate_n_per_s = 1e12;
  Cell out;
  for (int seed = 1; seed <= n_seeds; ++seed) {
    const auto number = static_cast<std::uint64_t>(seed);
    const Episode now = run_episode(gains, {}, broken, number, Told::by_its_watch, floor);
    out.before = worst_of(out.before,
                          run_episode(gains, free, broken, number, Told::by_its_watch, floor).peak);
    out.peak = worst_of(out.peak, now.peak);
    out.acceleration = worst_of(out.acceleration, now.acceleration);
    const Episode known = run_episode(gains, {}, broken, number, Told::at_once, floor);
    out.known = worst_of(out.known, known.peak);
    out.known_acceleration = worst_of(out.known_acceleration, known.acceleration);
    out.found_s = std::max(out.found_s, now.found_s);
    const bool names = now.fault == Fault::restless || now.fault == Fault::disobeyed;
    out.n_naming += names ? 1 : 0;
    out.n_named += names && now.named ? 1 : 0;
  }
  return out;
}

int run(const std::string& controller, const std::string& scene, int n_seeds, double floor,
        const std::string& wanted) {
  const Gains gains = shipped_gains(controller, scene);
  const Cell sound = cell(gains, {}, n_seeds, floor);
  std::printf(
      "Undisturbed %.2f / %.2f.\n\n| what breaks | sensor | read-back | actuator "
      "|\n|---|---|---|---|\n",
      sound.peak, sound.acceleration);
  for (const Broken& broken : all_broken()) {
    if (broken.part != Part::actuator) continue;
    if (broken.damage_name().find(wanted) == std::string::npos) continue;
    std::printf("| %s |", broken.damage_name().c_str());
    for (const Part part : {Part::sensor, Part::read_back, Part::actuator}) {
      if (part == Part::sensor && broken.damage == Damage::early) {
        std::printf(" |");
        continue;
      }
      const Cell one = cell(gains, {{part, broken.damage, broken.size}}, n_seeds, floor);
      std::printf(" %.3g -> **%.2f / %.2f** (%.2f / %.2f)", one.before, one.peak, one.acceleration,
                  one.known, one.known_acceleration);
      if (one.found_s >= 0) std::printf(", %.3g s", one.found_s);
      if (one.n_naming > 0) std::printf(", %d of %d", one.n_named, one.n_naming);
      std::printf(" |");
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}

/// The same of a sensor of the floor.
int run_lies(const std::string& controller, const std::string& scene, int n_seeds, double floor,
             const std::string& wanted) {
  const Gains gains = shipped_gains(controller, scene);
  if (gains.heard_floor().empty()) {
    throw std::runtime_error("--controller: " + controller + " hears no floor");
  }
  std::printf(
      "| a floor sensor | leg force | frame | faded out | let go of |\n|---|---|---|---|---|\n");
  for (const Lie& lie : all_lies()) {
    if (lie.name.find(wanted) == std::string::npos) continue;
    LieEpisode worst;
    int n_disbelieved = 0, n_faulty = 0;
    for (int seed = 1; seed <= n_seeds; ++seed) {
      const LieEpisode one = run_lie(gains, lie, static_cast<std::uint64_t>(seed), floor);
      worst.leg_force = worst_of(worst.leg_force, one.leg_force);
      worst.acceleration = worst_of(worst.acceleration, one.acceleration);
      n_disbelieved += one.disbelieved ? 1 : 0;
      n_faulty += one.faulty ? 1 : 0;
    }
    std::printf("| %s | %.2f | %.2f | %d of %d | %d |\n", lie.name.c_str(), worst.leg_force,
                worst.acceleration, n_disbelieved, n_seeds, n_faulty);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  cli::Command app(
      "Breaks every sensor, read-back and actuator of the shipped frame on the bench of the tests: "
      "the largest leg force over that of the passive frame in the same samples, without and with "
      "the "
      "pace, and behind the stroke the frame's acceleration; in brackets those of a loop that is "
      "told at once and lets go, and the longest time to the fault.\nExit codes: 0 done, 2 bad "
      "usage.",
      "broken_channels");
  std::string controller = "force_feedback_5hz", scene = "metrology_frame";
  std::string wanted;
  int n_seeds = 10;
  bool floor_sensors = false;
  double floor = usual_floor;
  app.option("--controller", controller, "One of config/controllers").show_default();
  app.option("--scene", scene, "That frame, or frame_under_gravity").show_default();
  app.option("--floor", floor, "Size of the floor, m/s^2")
      .check(cli::number_between(1e-9, 1.0))
      .show_default();
  app.option("--damage", wanted, "Only those whose name has this in it, as scaled");
  app.flag("--floor-sensors", floor_sensors,
           "Sensors of the floor instead, of a controller with a feed-forward");
  app.option("--seeds", n_seeds, "Episodes of each")
      .check(cli::whole_number(1, 1000))
      .show_default();
  try {
    if (const auto code = app.parse(argc, argv)) return *code;
    if (floor_sensors) return run_lies(controller, scene, n_seeds, floor, wanted);
    return run(controller, scene, n_seeds, floor, wanted);
  } catch (const std::exception& error) {
    std::cerr << "broken_channels: " << error.what() << "\n";
    return 2;
  }
}

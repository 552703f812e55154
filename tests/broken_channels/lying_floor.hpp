#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/io.hpp"

namespace stillframe::controller {

/// What a sensor of the floor reads in the place of what it should.
struct Lie {
  struct At {
    Measurement& measurement;
    Eigen::Index sensor;
    double t;      ///< s since it began
    double first;  ///< m/s^2, what it read then
    double late;   ///< m/s^2, what it should have read 20 samples ago
    std::mt19937_64& random;
  };
  std::string name;
  std::function<void(At&)> tell;
};

std::vector<Lie> all_lies();

/// What came of it, over the passive frame in the same ten seconds of the same floor.
struct LieEpisode {
  double leg_force = 0, acceleration = 0;
  bool faulty = false;       ///< the loop was let go of
  bool disbelieved = false;  ///< the feed-forward was faded out for a while
};

/// When it lies, and what beside it.
struct LieTiming {
  bool from_the_beginning = false;  ///< else once the loop has been active for two seconds
  bool early = false;               ///< peaks count from the first sample on
  double lasts_s = 10;
  int lost_of_200 = 0;  ///< measurements in a row, from when it lies
};

/// The loop of these gains, which hear the floor, on a floor of that size (m/s^2), with the noise
/// of its sensors (1 mN; 1e-6 m/s^2/sqrt(Hz)). Sensor and noise by seed.
LieEpisode run_lie(const Gains& gains, const Lie& lie, std::uint64_t seed, double floor_size,
                   const LieTiming& timing = {});

}  // namespace stillframe::controller

#include "tests/broken_channels/lying_floor.hpp"

#include <cmath>
#include <deque>
#include <stdexcept>

#include "tests/controller/made_up_floor.hpp"
#include "tests/controller/rig.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double normal(std::mt19937_64& random) { return std::normal_distribution<double>()(random); }

double& reading(Lie::At& at) { return at.measurement.floor(at.sensor); }

Lie off_by(double offset) {
  return {"off by " + std::to_string(offset).substr(0, 4) + " m/s^2 all at once",
          [offset](Lie::At& at) { reading(at) += offset; }};
}

Lie scaled(double factor) {
  return {std::to_string(factor).substr(0, 4) + " times",
          [factor](Lie::At& at) { reading(at) *= factor; }};
}

Lie noise(double size) {
  return {"noise of " + std::to_string(size).substr(0, 4) + " m/s^2",
          [size](Lie::At& at) { reading(at) += size * normal(at.random); }};
}

Lie spikes(double size) {
  return {"one sample in a hundred off by " + std::to_string(size).substr(0, 4) + " m/s^2",
          [size](Lie::At& at) {
            if (at.random() % 100 == 0) reading(at) += size;
          }};
}

Lie hums(double hz) {
  return {"0.05 m/s^2 of " + std::to_string(static_cast<int>(hz)) + " Hz beside the floor",
          [hz](Lie::At& at) { reading(at) += 0.05 * std::sin(two_pi * hz * at.t); }};
}

}  // namespace

std::vector<Lie> all_lies() {
  return {{"sound", [](Lie::At&) {}},
          {"dead", [](Lie::At& at) { reading(at) = 0; }},
          {"frozen", [](Lie::At& at) { reading(at) = at.first; }},
          {"reversed", [](Lie::At& at) { reading(at) *= -1; }},
          {"swapped with another",
           [](Lie::At& at) {
             VectorXd& w = at.measurement.floor;
             std::swap(w(at.sensor), w((at.sensor + 1) % w.size()));
           }},
          {"20 samples late", [](Lie::At& at) { reading(at) = at.late; }},
          scaled(0.5),
          scaled(3),
          scaled(10),
          hums(49),
          hums(200),
          noise(0.02),
          noise(0.2),
          spikes(0.1),
          spikes(1),
          {"drifts by 0.1 m/s^2 a second", [](Lie::At& at) { reading(at) += 0.1 * at.t; }},
          off_by(0.01),
          off_by(0.1),
          off_by(1),
          {"all reversed", [](Lie::At& at) { at.measurement.floor *= -1; }},
          {"all with noise of 0.02 m/s^2", [](Lie::At& at) {
             for (double& w : at.measurement.floor) w += 0.02 * normal(at.random);
           }}};
}

LieEpisode run_lie(const Gains& gains, const Lie& lie, std::uint64_t seed, double floor_size,
                   const LieTiming& timing) {
  const double rate = gains.sample_rate_hz;
  const auto samples = [&](double s) { return static_cast<int>(std::lround(s * rate)); };
  Rig rig({}, true, gains), passive({}, false, gains);
  for (Rig* each : {&rig, &passive}) {
    each->floor = [floor_size, floor = MadeUpFloor(rate, seed)](std::int64_t, VectorXd& w) mutable {
      floor(floor_size, w);
    };
  }
  std::mt19937_64 random(seed);
  const auto sensor = static_cast<Index>(seed) % gains.plant.B_w.cols();
  bool lies = timing.from_the_beginning, lossy = false;
  std::int64_t since = 0;
  double first = 0;
  std::deque<double> heard;
  const auto wire = [&](Measurement& m) {
    for (double& sigma : m.sigma) sigma += 1e-3 * normal(random);
    for (double& w : m.floor) w += 1e-6 * std::sqrt(rate / 2) * normal(random);
    heard.push_back(m.floor(sensor));
    if (heard.size() > 21) heard.pop_front();
    if (!lies) {
      first = m.floor(sensor);
      since = m.seq;
      return true;
    }
    Lie::At at{.measurement = m,
               .sensor = sensor,
               .t = static_cast<double>(m.seq - since) / rate,
               .first = first,
               .late = heard.front(),
               .random = random};
    lie.tell(at);
    return !lossy || m.seq % 200 >= timing.lost_of_200;
  };
  // A controller may refuse to begin with such a sensor.
  const bool active = rig.reaches(State::active, samples(4), wire);
  if (!active && !lies) throw std::runtime_error("not active");
  rig.steps(samples(2), wire);
  passive.steps(static_cast<int>(rig.k()));
  lies = lossy = true;
  if (!timing.early) rig.peak = rig.peak_y = passive.peak = passive.peak_y = 0;
  LieEpisode found;
  for (int k = 0; k < samples(timing.lasts_s); ++k) {
    rig.step(wire);
    passive.step();
    found.disbelieved |= rig.supervisor().broken_floor() >= 0;
  }
  found.leg_force = rig.peak / passive.peak;
  found.acceleration = rig.peak_y / passive.peak_y;
  found.faulty = rig.fault() != Fault::none;
  return found;
}

}  // namespace stillframe::controller

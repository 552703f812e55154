#include "tests/broken_channels/episodes.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "core/numerics/worst.hpp"
#include "judge/loop_design.hpp"
#include "tests/controller/made_up_floor.hpp"
#include "tests/controller/rig.hpp"

namespace stillframe::controller {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double noise = 1e-3;

}  // namespace

Gains shipped_gains(const std::string& controller, const std::string& scene) {
  const auto config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";
  Gains gains =
      judge::make_loop_design(config / "scenes" / (scene + ".yaml"),
                              config / "controllers" / (controller + ".yaml"), std::nullopt)
          .gains;
  // sigma = K q + u with q the elongations: the last states are their rates.
  const Index m = gains.n_legs();
  const double damping_over_stiffness = 1000 / 3.95e6;
  gains.plant.A.bottomRightCorner(m, m) +=
      damping_over_stiffness * gains.plant.A.bottomLeftCorner(m, m);
  return gains;
}

LeftAlone::LeftAlone(const Gains& gains, std::uint64_t seed, double floor_size)
    : seed_(seed),
      floor_size_(floor_size),
      rig_(std::make_unique<Rig>(Policy{}, /*active=*/false, gains)) {
  rig_->floor = [floor_size, floor = MadeUpFloor(gains.sample_rate_hz, seed)](
                    std::int64_t, VectorXd& w) mutable { floor(floor_size, w); };
}

LeftAlone::~LeftAlone() = default;

std::pair<double, double> LeftAlone::peaks(std::int64_t begin, std::int64_t end) {
  // No loop has to wake up for a frame that none controls.
  const auto nothing = [](Measurement&) { return false; };
  while (static_cast<std::int64_t>(samples_.size()) < end) {
    rig_->peak = rig_->peak_y = 0;
    rig_->step(nothing, /*awake=*/false);
    samples_.emplace_back(rig_->peak, rig_->peak_y);
  }
  std::pair<double, double> most;
  for (std::int64_t k = begin; k < end; ++k) {
    const auto& [sigma, y] = samples_[static_cast<std::size_t>(k)];
    most = {worst_of(most.first, sigma), worst_of(most.second, y)};
  }
  return most;
}

Episode run_episode(const Gains& gains, const Policy& policy, const std::vector<Broken>& broken,
                    std::uint64_t seed, Told told, double floor_size, int n_lost,
                    std::optional<LeftAlone>* alone) {
  const auto samples = [&](double seconds) {
    return static_cast<int>(seconds * gains.sample_rate_hz);
  };
  std::mt19937_64 random(seed);
  Rig rig(policy, true, gains);
  rig.floor = [floor_size, floor = MadeUpFloor(gains.sample_rate_hz, seed)](
                  std::int64_t, VectorXd& w) mutable { floor(floor_size, w); };
  std::normal_distribution<double> normal;
  bool is_broken = false;
  std::int64_t since = 0;
  std::vector<Breaker> breakers;
  std::vector<Index> legs;
  for (const Broken& each : broken) {
    const auto leg = static_cast<Index>(random() % static_cast<std::uint64_t>(gains.n_legs()));
    legs.push_back(leg);
    if (each.damage == Damage::swapped) legs.push_back((leg + 1) % gains.n_legs());
    breakers.emplace_back(each, leg, gains.sample_time(), noise, random());
  }
  const auto damage = [&](Part part, VectorXd& values) {
    for (std::size_t i = 0; is_broken && i < broken.size(); ++i) {
      if (broken[i].part == part) breakers[i](values, rig.next_force());
    }
  };
  rig.actuators = [&](VectorXd& force) { damage(Part::actuator, force); };
  const auto wire = [&](Measurement& m) {
    for (double& value : m.sigma) value += noise * normal(random);
    damage(Part::sensor, m.sigma);
    damage(Part::read_back, m.applied);
    if (!is_broken) return true;
    return told == Told::by_its_watch && (m.seq - since) % samples(1) >= n_lost;
  };
  Episode episode;
  if (!rig.reaches(State::active, samples(3), wire)) {
    throw std::runtime_error("a sound loop does not become active: " +
                             std::string(to_text(rig.fault())));
  }
  rig.steps(samples(1) + static_cast<int>(random() % static_cast<std::uint64_t>(samples(2))), wire);
  if (rig.state() != State::active) throw std::runtime_error("a sound loop does not stay active");
  is_broken = true;
  since = rig.k();
  rig.peak = rig.peak_y = 0;
  for (int k = 0; k < samples(4); ++k) {
    rig.step(wire);
    if (episode.found_s < 0 && rig.state() == State::fault) {
      episode.found_s = static_cast<double>(rig.k() - since) * gains.sample_time();
    }
  }
  std::optional<LeftAlone> own;
  if (alone == nullptr) alone = &own;
  if (!*alone || (*alone)->seed() != seed || (*alone)->floor_size() != floor_size) {
    alone->emplace(gains, seed, floor_size);
  }
  const auto [peak, peak_y] = (*alone)->peaks(since, rig.k());
  episode.peak = rig.peak / peak;
  episode.acceleration = rig.peak_y / peak_y;
  episode.fault = rig.fault();
  episode.latched = rig.latched();
  episode.named = std::ranges::find(legs, rig.supervisor().first_leg()) != legs.end();
  return episode;
}

}  // namespace stillframe::controller

// Converter cards that are not there, as a program of its own: it measures and drives the plant of
// a gains file by a clock of its own, and talks to the controller over two pipes. Where its cables,
// signs and clock are not what the rig file says is for you to choose.
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <string>

#include "controller/rig/device_frames.hpp"
#include "controller/rig/simulated_plant.hpp"
#include "msgs/clock.hpp"

using namespace stillframe::controller;

namespace {

constexpr const char* usage =
    "usage: converter GAINS FROM TO [key=value ...]\n"
    "FROM and TO are pipes, made if they are not there: samples go to FROM, commands come by TO.\n"
    "  duration=10     s; 0: until it is told to stop\n"
    "  ppm=0           its clock is fast by so much\n"
    "  jitter_us=0     samples are late by up to so much\n"
    "  step_n=0.01     N a count; 16 bits then reach 328 N\n"
    "  gap_every=0     every so many samples, three are not sent\n"
    "  pause_at=0      s, when it begins anew: 0.3 s later its numbers are 0 again\n"
    "  swap=no         yes: sigma of the first two legs is on each other's cables\n"
    "  flip=no         yes: the amplifier of the first leg is wired the other way round\n"
    "  gains_off=0     %: of leg i, from 1, the force sensor reads cos(i) of that too much, and "
    "the\n"
    "                  amplifier, with what is read of it, makes cos(2 i)\n"
    "  floor_rms=0.003 m/s^2\n";

volatile std::sig_atomic_t stop = 0;

int open_pipe(const char* path) {
  mkfifo(path, 0600);
  return open(path, O_RDWR | O_NONBLOCK);
}

std::uint32_t counts(double value) {
  return static_cast<std::uint32_t>(
      static_cast<std::int32_t>(std::clamp(std::round(value), -32768.0, 32767.0)));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 4) {
    std::cerr << usage;
    return 2;
  }
  std::map<std::string, std::string> of = {
      {"duration", "10"},     {"ppm", "0"},      {"jitter_us", "0"}, {"step_n", "0.01"},
      {"gap_every", "0"},     {"pause_at", "0"}, {"swap", "no"},     {"flip", "no"},
      {"floor_rms", "0.003"}, {"gains_off", "0"}};
  for (int i = 4; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string key = word.substr(0, word.find('='));
    if (!of.contains(key) || word.size() <= key.size() + 1) {
      std::cerr << "converter: " << word << ": no such key, or no value\n" << usage;
      return 2;
    }
    of[key] = word.substr(key.size() + 1);
  }
  const auto number = [&](const char* key) { return std::atof(of.at(key).c_str()); };
  const Gains gains = read_gains(argv[1]);
  SimulatedPlant plant(gains, number("floor_rms"));
  const int out = open_pipe(argv[2]), in = open_pipe(argv[3]);
  if (out < 0 || in < 0) throw std::runtime_error("the pipes cannot be opened");
  std::signal(SIGINT, [](int) { stop = 1; });
  std::signal(SIGTERM, [](int) { stop = 1; });

  const Eigen::Index m = gains.n_legs();
  const auto n_legs = static_cast<std::size_t>(m);
  FrameSearch search(mark_commands, n_legs + 4);
  std::vector<std::uint32_t> frame(2 * n_legs + 3);
  frame.front() = mark_samples;
  Measurement read = measurement_of(m, 0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(m), acting = force;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(0, number("jitter_us") * 1e3);
  const double period_ns = plant.sample_time() * 1e9 / (1 + 1e-6 * number("ppm")),
               step = number("step_n");
  const auto gain = [&](double turns) { return 1 + number("gains_off") / 100 * std::cos(turns); };
  Eigen::VectorXd gain_sigma(m), gain_force(m);
  for (Eigen::Index leg = 0; leg < m; ++leg) {
    gain_sigma(leg) = gain(static_cast<double>(leg + 1));
    gain_force(leg) = gain(static_cast<double>(2 * (leg + 1)));
  }
  const bool swap = of["swap"] == "yes", flip = of["flip"] == "yes";
  const auto gap_every = static_cast<std::int64_t>(number("gap_every"));
  const auto n = static_cast<std::int64_t>(number("duration") / plant.sample_time());
  const auto pause_at = static_cast<std::int64_t>(number("pause_at") / plant.sample_time());
  const auto pause = static_cast<std::int64_t>(0.3 / plant.sample_time());
  const std::int64_t start = stillframe::monotonic_ns();
  std::int64_t unheard = 0, n_enabled = 0;
  double largest = 0;
  std::uint32_t seq = 0;
  for (std::int64_t k = 0; (n == 0 || k < n) && stop == 0; ++k) {
    stillframe::sleep_until(start +
                            std::llround(static_cast<double>(k) * period_ns + jitter(random)));
    // What came since the sample before stands for it; amplifiers that hear nothing let go.
    ++unheard;
    for (;;) {
      const auto room = search.room();
      const ssize_t bytes = ::read(in, room.data(), room.size());
      if (bytes > 0) search.filled(static_cast<std::size_t>(bytes));
      const auto command = search.next();
      if (command.empty() && bytes <= 0) break;
      if (command.empty()) continue;
      unheard = 0;
      n_enabled += command[2];
      for (Eigen::Index leg = 0; leg < m; ++leg) {
        force(leg) = gain_force(leg) * step *
                     static_cast<std::int32_t>(command[static_cast<std::size_t>(leg) + 3]) *
                     command[2];
      }
      if (flip) force(0) = -force(0);
    }
    acting = unheard > 10 ? Eigen::VectorXd(0.99 * acting) : force;
    if (k > 0) plant.advance(acting);
    plant.read(read);
    largest = std::max(largest, read.sigma.lpNorm<Eigen::Infinity>());
    const bool away = pause_at > 0 && k >= pause_at && k < pause_at + pause;
    if (pause_at > 0 && k == pause_at + pause) seq = 0;
    if (!away && !(gap_every > 0 && k % gap_every < 3 && k >= gap_every)) {
      for (Eigen::Index leg = 0; leg < m; ++leg) {
        const Eigen::Index cable = swap && leg < 2 ? 1 - leg : leg;
        frame[static_cast<std::size_t>(2 + cable)] =
            counts(gain_sigma(leg) * read.sigma(leg) / step);
        frame[static_cast<std::size_t>(2 + m + leg)] = counts(read.applied(leg) / step);
      }
      frame[1] = seq;
      frame.back() = sum_of(std::span(frame).first(frame.size() - 1));
      if (write(out, frame.data(), 4 * frame.size()) < 0) { /* nobody listens yet */
      }
    }
    ++seq;
  }
  std::cout << "converter: a leg pushed the frame by " << largest << " N at most, amplifiers "
            << (n_enabled > 0 ? "" : "never ") << "enabled\n";
} catch (const std::exception& error) {
  std::cerr << "converter: " << error.what() << "\n";
  return 2;
}

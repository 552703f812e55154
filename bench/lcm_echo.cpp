// LCM round trip: a measurement out, its command back, once from a process that does nothing but
// publish the bytes that it hears, and once from stillframe-controller in lock-step, which answers
// as soon as it can. Both live at the same time, on two ports of one private network, at the same
// priority, and take turns by blocks.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <memory>
#include <random>

#include "bench/machine.hpp"
#include "bench/times.hpp"
#include "controller/gains.hpp"
#include "core/cli/command.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"

namespace {

using namespace stillframe;
using namespace stillframe_msgs;

constexpr const char* echo_url = "udpm://239.255.76.67:7701?ttl=0";
constexpr const char* controller_url = "udpm://239.255.76.67:7702?ttl=0";

struct Options {
  std::string gains, controller;
  std::vector<std::string> controller_options;
  int priority = 49, n_blocks = 40, n_pings = 500;
  double rate_hz = 1000;
};

class Echo {
 public:
  explicit Echo(const char* url) : lcm_(url) {
    lcm_.subscribe(channels::measurement, &Echo::on_measurement, this);
  }
  [[noreturn]] void run() {
    for (;;) lcm_.handle();
  }

 private:
  void on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) {
    lcm_.publish(channel_, buffer->data, buffer->data_size);
  }

  lcm::LCM lcm_;
  const std::string channel_ = channels::command;
};

/// The plant's end of one port.
class Pinger {
 public:
  Pinger(const char* url, const run_info_t& info) : lcm_(open_lcm(url)), info_(info) {
    lcm_->subscribe(channels::command, &Pinger::on_command, this);
    lcm_->subscribe(channels::run_state, &Pinger::on_state, this);
    message_.run_id = info.run_id;
    message_.plant_instance = info.plant_instance;
    message_.n_floor = info.n_floor;
    message_.n_legs = info.n_legs;
    message_.n_frame = info.n_frame;
    message_.floor_acceleration.resize(static_cast<std::size_t>(info.n_floor));
    message_.sigma.resize(static_cast<std::size_t>(info.n_legs));
    message_.applied_force.resize(static_cast<std::size_t>(info.n_legs));
    message_.frame_acceleration.resize(static_cast<std::size_t>(info.n_frame));
    bytes_.resize(static_cast<std::size_t>(message_.getEncodedSize()));
  }

  /// Until the controller is ready; an echo needs none of it.
  void shake_hands() {
    for (int i = 0; i < 200 && !ready_; ++i) {
      say(run_state_t::WAITING);
      lcm_->publish(channels::run_info, &info_);
      handle_one(*lcm_, 50);
    }
    if (!ready_) throw std::runtime_error("the controller does not answer");
    say(run_state_t::RUNNING);
  }

  void say(std::int32_t state) {
    run_state_t message{};
    message.run_id = info_.run_id;
    message.plant_instance = message.instance = info_.plant_instance;
    message.sent_ns = monotonic_ns();
    message.source = "plant";
    message.state = state;
    lcm_->publish(channels::run_state, &message);
  }

  /// ns from before publish to the answer's handler, or -1.
  std::int64_t ping() {
    ++message_.seq;
    message_.time_ns = message_.seq * 1'000'000;
    for (double& f : message_.sigma) f = noise_(random_);
    const int size = message_.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
    answered_ns_ = -1;
    const std::int64_t begin = monotonic_ns();
    lcm_->publish(channel_, bytes_.data(), static_cast<unsigned>(size));
    while (answered_ns_ < 0 && handle_one(*lcm_, 1000)) {
    }
    return answered_ns_ < 0 ? -1 : answered_ns_ - begin;
  }

 private:
  // The number stands at the same place in both types, which is all that an echo leaves to check.
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
    std::int64_t seq = -1;
    __int64_t_decode_array(buffer->data, 32, static_cast<int>(buffer->data_size) - 32, &seq, 1);
    if (seq == message_.seq) answered_ns_ = monotonic_ns();
  }
  void on_state(const lcm::ReceiveBuffer*, const std::string&, const run_state_t* message) {
    if (message->source == "controller") ready_ = message->state == run_state_t::READY;
  }

  std::unique_ptr<lcm::LCM> lcm_;
  run_info_t info_;
  measurement_t message_{};
  const std::string channel_ = channels::measurement;
  std::vector<std::uint8_t> bytes_;
  bool ready_ = false;
  std::int64_t answered_ns_ = -1;
  std::mt19937_64 random_{1};
  std::normal_distribution<double> noise_;
};

run_info_t run_of(const controller::Gains& gains, const Options& options) {
  run_info_t info{};
  info.run_id = 1;
  info.plant_instance = 1;
  info.format_version = 1;
  info.scene_name = "round trip";
  info.scene_hash = gains.scene_hash;
  info.mode = "lock_step";
  info.loop = "active";
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = gains.delay_samples;
  info.n_samples = static_cast<std::int64_t>(options.n_blocks) * options.n_pings;
  info.n_legs = static_cast<std::int32_t>(gains.legs.size());
  info.leg_names = gains.legs;
  info.n_floor = info.n_frame = 6;
  info.floor_names = info.frame_names = {"a", "b", "c", "d", "e", "f"};
  return info;
}

pid_t start_echo(int priority) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    use_fifo(priority);
    Echo(echo_url).run();
  } catch (...) {
    _exit(4);
  }
}

pid_t start_controller(const Options& options) {
  std::vector<std::string> words{options.controller, "--gains",   options.gains, "--lcm-url",
                                 controller_url,     "--timeout", "60"};
  words.insert(words.end(), options.controller_options.begin(), options.controller_options.end());
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    use_fifo(options.priority);
  } catch (...) {
    _exit(4);
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

int block(Pinger& pinger, const Options& options, Times& times) {
  const auto period = static_cast<std::int64_t>(1e9 / options.rate_hz);
  int n_lost = 0;
  std::int64_t next = monotonic_ns();
  for (int i = 0; i < options.n_pings; ++i) {
    next = std::max(next + period, monotonic_ns());
    sleep_until(next);
    const std::int64_t ns = pinger.ping();
    if (ns < 0) ++n_lost;
    if (ns >= 0) times.add(ns);
  }
  return n_lost;
}

void print_ratios(const std::vector<Times>& echo, const std::vector<Times>& own) {
  Times all_echo(0), all_own(0), medians(echo.size());
  std::vector<double> ratios;
  for (std::size_t i = 0; i < echo.size(); ++i) {
    all_echo.append(echo[i]);
    all_own.append(own[i]);
    ratios.push_back(static_cast<double>(own[i].quantile(0.5)) /
                     static_cast<double>(echo[i].quantile(0.5)));
  }
  std::sort(ratios.begin(), ratios.end());
  Times::print_head("round trip");
  all_echo.print_row("bare LCM echo");
  all_own.print_row("stillframe-controller");
  const auto ratio = [&](double part) {
    return static_cast<double>(all_own.quantile(part)) /
           static_cast<double>(all_echo.quantile(part));
  };
  const auto n = ratios.size();
  std::printf("ratio: p50 %.3f (blocks: quartiles %.3f to %.3f), p99 %.3f, p99.9 %.3f\n",
              ratio(0.5), ratios[n / 4], ratios[n - 1 - n / 4], ratio(0.99), ratio(0.999));
}

void run(const Options& options) {
  const run_info_t info = run_of(controller::read_gains(options.gains), options);
  const pid_t children[] = {start_echo(options.priority), start_controller(options)};
  use_fifo(options.priority);
  Pinger to_echo(echo_url, info), to_own(controller_url, info);
  to_own.shake_hands();
  std::vector<Times> echo, own;
  int n_lost = 0;
  for (int i = 0; i < options.n_blocks; ++i) {
    const auto n = static_cast<std::size_t>(options.n_pings);
    echo.emplace_back(n);
    own.emplace_back(n);
    // ABBA, so that a slow drift of the machine meets both alike.
    if (i % 2 == 0) n_lost += block(to_echo, options, echo.back());
    n_lost += block(to_own, options, own.back());
    if (i % 2 == 1) n_lost += block(to_echo, options, echo.back());
  }
  to_own.say(run_state_t::ENDED);
  kill(children[0], SIGKILL);
  for (const pid_t child : children) waitpid(child, nullptr, 0);
  std::printf("%s\n%d blocks of %d, %g Hz, priority %d, %d lost\n",
              machine_line(STILLFRAME_FLAGS).c_str(), options.n_blocks, options.n_pings,
              options.rate_hz, options.priority, n_lost);
  print_ratios(echo, own);
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  cli::Command app("LCM round trip of stillframe-controller in lock-step beside a bare echo.");
  app.option("gains", options.gains, "gains file").required();
  app.option("--controller", options.controller, "the program").required();
  app.option("--controller-option", options.controller_options, "one more word for it");
  app.option("--priority", options.priority, "SCHED_FIFO, 0: ordinary");
  app.option("--blocks", options.n_blocks, "of either");
  app.option("--pings", options.n_pings, "in a block");
  app.option("--rate", options.rate_hz, "pings a second");
  if (const auto code = app.parse(argc, argv)) return *code;
  run(options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_lcm_echo: %s\n", error.what());
  return 4;
}

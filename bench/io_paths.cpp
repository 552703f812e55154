// Ways for a command to leave the loop: what each costs a periodic SCHED_FIFO loop, how late that
// makes its periods, and when the receiver has the command; with nothing in the way, with many or
// stopped listeners, and with a network so slow that the sender's socket is full. To be run as root
// by scripts/private_network, since it slows its loopback interface down.
#include <arpa/inet.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <thread>

#include "bench/machine.hpp"
#include "bench/times.hpp"
#include "controller/lcm_stream.hpp"
#include "controller/realtime.hpp"
#include "core/cli/command.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/command_t.hpp"

namespace {

using namespace stillframe;
using stillframe_msgs::command_t;

constexpr const char* url = "udpm://239.255.76.67:7703?ttl=0";
constexpr int n_legs = 6;

struct Options {
  double rate_hz = 1000, slice_s = 3;
  int n_slices = 4;
  std::int64_t priority = 49;
};

/// A way for a command to leave the loop; false if it was dropped.
class Way {
 public:
  virtual ~Way() = default;
  virtual bool send(const controller::Command& command) noexcept = 0;
};

class Encoder {
 public:
  Encoder() {
    message_.run_id = 1;
    message_.n_legs = n_legs;
    message_.force.assign(n_legs, 0.0);
    bytes_.resize(static_cast<std::size_t>(message_.getEncodedSize()));
  }
  const std::vector<std::uint8_t>& encode(const controller::Command& command) noexcept {
    message_.seq = command.seq;
    message_.time_ns = command.time_ns;
    for (std::size_t i = 0; i < n_legs; ++i) message_.force[i] = command.force(static_cast<int>(i));
    message_.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
    return bytes_;
  }

 private:
  command_t message_{};
  std::vector<std::uint8_t> bytes_;
};

class Publish : public Way {
 public:
  bool send(const controller::Command& command) noexcept override {
    const auto& bytes = encoder_.encode(command);
    return lcm_->publish(channel_, bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
  }

 private:
  std::unique_ptr<lcm::LCM> lcm_ = open_lcm(url);
  const std::string channel_ = channels::command;
  Encoder encoder_;
};

/// A socket of our own that never waits, with the header that LCM gives a message in one packet.
class OwnSocket : public Way {
 public:
  OwnSocket() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(7703);
    inet_aton("239.255.76.67", &to_.sin_addr);
    const unsigned char ttl = 0;
    setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    for (const char c : {'L', 'C', '0', '2', '\0', '\0', '\0', '\0'}) packet_.push_back(c);
    for (const char* c = channels::command; *c != '\0'; ++c) packet_.push_back(*c);
    packet_.push_back('\0');
    head_ = packet_.size();
    packet_.resize(head_ + encoder_.encode({.force = Eigen::VectorXd::Zero(n_legs)}).size());
  }
  ~OwnSocket() override { close(socket_); }
  bool send(const controller::Command& command) noexcept override {
    const auto& bytes = encoder_.encode(command);
    std::copy(bytes.begin(), bytes.end(), packet_.begin() + static_cast<std::ptrdiff_t>(head_));
    return sendto(socket_, packet_.data(), packet_.size(), MSG_DONTWAIT,
                  reinterpret_cast<const sockaddr*>(&to_), sizeof to_) > 0;
  }

 private:
  int socket_;
  sockaddr_in to_{};
  std::vector<char> packet_;
  std::size_t head_ = 0;
  Encoder encoder_;
};

class Stream : public Way {
 public:
  explicit Stream(const controller::Policy& policy) : stream_(url, run(), 1, policy) {}
  bool send(const controller::Command& command) noexcept override {
    const std::int64_t before = stream_.state().n_dropped;
    stream_.send(command);
    return stream_.state().n_dropped == before;
  }

 private:
  static stillframe_msgs::run_info_t run() {
    stillframe_msgs::run_info_t info{};
    info.run_id = 1;
    info.n_legs = n_legs;
    return info;
  }
  controller::LcmStream stream_;
};

std::unique_ptr<Way> make_way(int way, const controller::Policy& policy) {
  if (way == 0) return std::make_unique<Publish>();
  if (way == 1) return std::make_unique<OwnSocket>();
  return std::make_unique<Stream>(policy);
}
constexpr const char* way_names[] = {"lcm publish from the loop", "own socket, MSG_DONTWAIT",
                                     "ring, semaphore, thread"};

// --- the other processes

/// What the receiving process has measured, in memory that both share.
struct Received {
  static constexpr std::size_t capacity = 1 << 18;
  std::atomic<std::size_t> n;
  std::int64_t latency_ns[capacity];
};

Received* shared_memory() {
  void* memory =
      mmap(nullptr, sizeof(Received), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("mmap");
  return static_cast<Received*>(memory);
}

template <class Run>
pid_t start(const Run& run) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    run();
  } catch (...) {
  }
  _exit(4);
}

pid_t start_receiver(Received* received, std::int64_t priority) {
  return start([=] {
    use_fifo(static_cast<int>(priority));
    lcm::LCM lcm(url);
    const auto on_command = [](const lcm::ReceiveBuffer*, const std::string&,
                               const command_t* command, Received* to) {
      const std::size_t i = to->n.load();
      if (i >= Received::capacity) return;
      to->latency_ns[i] = monotonic_ns() - command->time_ns;
      to->n = i + 1;
    };
    lcm.subscribeFunction<command_t, Received*>(channels::command, on_command, received);
    for (;;) lcm.handle();
  });
}

pid_t start_listener() {
  return start([] {
    lcm::LCM lcm(url);
    const auto ignore = [](const lcm::ReceiveBuffer*, const std::string&, int) {};
    lcm.subscribeFunction<int>(channels::command, ignore, 0);
    for (;;) lcm.handle();
  });
}

pid_t start_logger() {
  return start([] {
    execlp("lcm-logger", "lcm-logger", "--quiet", "--force", "--lcm-url", url, "/dev/null",
           static_cast<char*>(nullptr));
  });
}

void end(pid_t child) {
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

// --- what is in the way

struct Hindrance {
  const char* name;
  int n_listeners;
  bool stopped_listener, stopped_logger;
  const char* rate;  ///< of the loopback interface
};
constexpr Hindrance hindrances[] = {
    {"one receiver", 0, false, false, nullptr},
    {"one receiver and 8 listeners", 8, false, false, nullptr},
    {"one receiver and a stopped listener", 1, true, false, nullptr},
    {"one receiver and a stopped lcm-logger", 0, false, true, nullptr},
    {"full socket: network of 200 kbit/s", 0, false, false, "200kbit"},
};

bool slow_network(const char* rate) {
  const std::string command = "PATH=$PATH:/usr/sbin:/sbin tc qdisc replace dev lo root tbf rate " +
                              std::string(rate) + " burst 2000 limit 100000000";
  return std::system(command.c_str()) == 0;
}
bool free_network() {
  return std::system("PATH=$PATH:/usr/sbin:/sbin tc qdisc del dev lo root") == 0;
}

struct Measured {
  Times cost{0}, late{0}, latency{0};
  std::int64_t n_dropped = 0, n_skipped = 0;
};

void run_loop(Way& way, const Options& options, Measured& to) {
  use_fifo(static_cast<int>(options.priority));
  const auto period = static_cast<std::int64_t>(1e9 / options.rate_hz);
  const auto n = static_cast<std::int64_t>(options.rate_hz * options.slice_s);
  Times cost(static_cast<std::size_t>(n)), late(static_cast<std::size_t>(n));
  controller::Command command{.force = Eigen::VectorXd::Zero(n_legs)};
  std::int64_t next = monotonic_ns() + period;
  for (std::int64_t k = 0; k < n; ++k, next += period) {
    sleep_until(next);
    const std::int64_t now = monotonic_ns();
    late.add(now - next);
    for (; next + period <= now; ++k, next += period) ++to.n_skipped;
    command.seq = k;
    command.time_ns = monotonic_ns();
    if (!way.send(command)) ++to.n_dropped;
    cost.add(monotonic_ns() - command.time_ns);
  }
  to.cost.append(cost);
  to.late.append(late);
}

bool slice(const Hindrance& hindrance, int way_number, const Options& options,
           const controller::Policy& policy, Measured& to) {
  static Received* received = shared_memory();
  received->n = 0;
  std::vector<pid_t> others;
  others.push_back(start_receiver(received, options.priority));
  for (int i = 0; i < hindrance.n_listeners; ++i) others.push_back(start_listener());
  if (hindrance.stopped_logger) others.push_back(start_logger());
  {
    const std::unique_ptr<Way> way = make_way(way_number, policy);
    const auto heard = [&] { return received->n.load() > 0; };
    for (int i = 0; i < 400 && !heard(); ++i) {
      way->send({.time_ns = monotonic_ns(), .force = Eigen::VectorXd::Zero(n_legs)});
      sleep_until(monotonic_ns() + 20'000'000);
    }
    if (!heard()) throw std::runtime_error("the receiver hears nothing");
    if (hindrance.stopped_listener || hindrance.stopped_logger) kill(others.back(), SIGSTOP);
    const bool possible = hindrance.rate == nullptr || slow_network(hindrance.rate);
    const std::size_t first = received->n;
    if (possible) std::thread([&] { run_loop(*way, options, to); }).join();
    if (hindrance.rate != nullptr) free_network();
    sleep_until(monotonic_ns() + 50'000'000);
    Times latency(Received::capacity);
    for (std::size_t i = first; i < received->n; ++i) latency.add(received->latency_ns[i]);
    to.latency.append(latency);
    for (const pid_t other : others) end(other);
    return possible;
  }
}

void measure(const Hindrance& hindrance, const Options& options, const controller::Policy& policy) {
  Measured measured[3];
  for (int i = 0; i < options.n_slices; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int way = i % 2 == 0 ? j : 2 - j;
      if (!slice(hindrance, way, options, policy, measured[way])) {
        std::printf("\n%s: tc cannot do this here\n", hindrance.name);
        return;
      }
    }
  }
  std::printf("\n%s\n", hindrance.name);
  Times::print_head("");
  for (int way = 0; way < 3; ++way) {
    const Measured& m = measured[way];
    const std::string name = way_names[way];
    m.cost.print_row(name + ": cost");
    m.late.print_row(name + ": wake-up");
    m.latency.print_row(name + ": to receiver");
    std::printf("%s: %lld periods skipped, %lld commands dropped\n", name.c_str(),
                static_cast<long long>(m.n_skipped), static_cast<long long>(m.n_dropped));
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  cli::Command app("Cost and latency of the ways for a command to leave the loop.");
  app.option("--rate", options.rate_hz, "of the loop, Hz");
  app.option("--slice", options.slice_s, "s");
  app.option("--slices", options.n_slices, "of every way, in turns");
  app.option("--priority", options.priority, "SCHED_FIFO of loop and receiver");
  if (const auto code = app.parse(argc, argv)) return *code;
  controller::Policy policy;
  policy.priority = options.priority;
  std::printf("%s; %g Hz\n", machine_line(STILLFRAME_FLAGS).c_str(), options.rate_hz);
  std::printf("%s\n", controller::prepare_process(policy).text.c_str());
  for (const Hindrance& hindrance : hindrances) measure(hindrance, options, policy);
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_io_paths: %s\n", error.what());
  return 4;
}

#include "tests/faults/rig.hpp"

#include <array>
#include <csignal>
#include <fstream>
#include <stdexcept>

#include "msgs/clock.hpp"

namespace stillframe::faults {

namespace {

// Above the controller's, below the relay's: a plant does not wait for its controller.
constexpr int plant_priority = 60;

constexpr double hold_s = 0.01;  // of the default policy at 1 kHz
// Each costs a loop at most the three seconds that it needs to come back: half of what is waited.
constexpr std::int64_t often = 5;

/// What the controller had in the newest of its periods, for a message.
std::string newest_periods(const Trace& trace) {
  constexpr std::size_t most = 5000;
  const std::size_t n = trace.periods.size(), first = n > most ? n - most : 0;
  std::array<int, 5> defects{};
  for (std::size_t i = first; i < n; ++i) {
    ++defects.at(static_cast<std::size_t>(trace.periods[i].defect));
  }
  return "of its last " + std::to_string(n - first) + " periods " + std::to_string(defects[0]) +
         " had a measurement, " + std::to_string(defects[1]) + " none, " +
         std::to_string(defects[2]) + " a late one";
}

std::string program(const char* name) { return std::string(STILLFRAME_BIN_DIR) + "/" + name; }

std::string port_url(int number, int side) {
  return "udpm://239.255.76.67:" + std::to_string(7700 + 2 * number + side) + "?ttl=0";
}

std::filesystem::path named(const Workbench& bench, const std::string& what, int number) {
  return bench.folder() / (what + "-" + std::to_string(number));
}

}  // namespace

Rig::Rig(Workbench& bench, const RigOptions& options)
    : bench_(bench),
      options_(options),
      relay_(port_url(options.number, 0), port_url(options.number, 1), bench.rate_hz()) {
  for (const char* what : {"plant.txt", "controller.txt", "another.txt", "latch.yaml"}) {
    std::filesystem::remove(named(bench_, what, options.number));  // of the rig before
  }
  if (!options_.policy.empty()) {
    std::ofstream(named(bench_, "policy.yaml", options_.number)) << options_.policy;
  }
}

std::string Rig::url(int side) const { return port_url(options_.number, side); }

void Rig::start_plant() {
  // The longest that the floor lasts; end() comes before.
  std::vector<std::string> command{program("stillframe-plant"),
                                   bench_.scene(),
                                   "--gains",
                                   bench_.gains(),
                                   "--mode",
                                   "wall_clock",
                                   "--duration",
                                   "200",
                                   "--lcm-url",
                                   url(0),
                                   "--run-id",
                                   std::to_string(options_.number + 1)};
  plant_ = std::make_unique<Process>(command, named(bench_, "plant.txt", options_.number),
                                     plant_priority);
}

std::vector<std::string> Rig::controller_command() const {
  std::vector<std::string> command = options_.controller_prefix;
  for (const std::string& word :
       {program("stillframe-controller"), std::string("--gains"), bench_.gains().string(),
        std::string("--lcm-url"), url(1), std::string("--run-id"),
        std::to_string(options_.number + 1), std::string("--flight-folder"),
        bench_.folder().string(), std::string("--latch"),
        named(bench_, "latch.yaml", options_.number).string()}) {
    command.push_back(word);
  }
  if (!options_.policy.empty()) {
    command.push_back("--policy");
    command.push_back(named(bench_, "policy.yaml", options_.number));
  }
  return command;
}

void Rig::start_controller() {
  controller_ = std::make_unique<Process>(controller_command(),
                                          named(bench_, "controller.txt", options_.number));
  relay_.follow(controller_->pid());
}

std::unique_ptr<Process> Rig::another_controller() {
  return std::make_unique<Process>(controller_command(),
                                   named(bench_, "another.txt", options_.number));
}

void Rig::wait_for_sample(std::int64_t sample) {
  wait("sample " + std::to_string(sample),
       [sample](const Trace& trace) { return trace.sample() >= sample; });
}

void Rig::wait_samples(std::int64_t n) {
  wait_for_sample(relay_.look([](const Trace& trace) { return trace.sample(); }) + n);
}

void Rig::wait(const std::string& what, const std::function<bool(const Trace&)>& condition) {
  std::int64_t n_still = 0;
  for (int i = 0; i < most_waits; ++i) {
    const std::int64_t begin_ns = monotonic_ns();
    if (relay_.wait(condition, limit_s)) return;
    n_still = bench_.bystander().n_later_than(hold_s, begin_ns, monotonic_ns());
    if (n_still < often) break;
  }
  const std::string state = relay_.look([](const Trace& trace) {
    return trace.status() == nullptr ? "no word from the controller"
                                     : "the controller: " + trace.status()->text;
  });
  const std::string text =
      "waited for " + what + "; in the last " + std::to_string(static_cast<int>(limit_s)) +
      " s the machine stood still for longer than the controller holds a force " +
      std::to_string(n_still) + " times; " + state + "; " + relay_.look(newest_periods) +
      "\nplant:\n" + plant_->said() + "controller:\n" + controller_->said();
  if (n_still >= often) throw MachineTrouble(text);
  throw std::runtime_error(text);
}

void Rig::ask(std::int32_t request) {
  stillframe_msgs::control_request_t message;
  message.run_id = 0;
  message.nonce = ++nonce_;
  message.asked_ns = monotonic_ns();
  message.request = request;
  const auto heard = [this](const Trace& trace) {
    return trace.status() != nullptr && trace.status()->nonce == nonce_;
  };
  // Again and again as `stillframe ctl` does; it is obeyed once.
  for (int i = 0; i < 10 * static_cast<int>(limit_s); ++i) {
    message.sent_ns = monotonic_ns();
    relay_.request(message);
    if (relay_.wait(heard, 0.1)) return;
  }
  throw std::runtime_error("no controller heard request " + std::to_string(request));
}

std::optional<int> Rig::end() {
  plant_->signal(SIGTERM);
  plant_->wait(limit_s);
  return controller_->wait(limit_s);
}

}  // namespace stillframe::faults

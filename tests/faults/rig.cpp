#include "tests/faults/rig.hpp"

#include <csignal>
#include <fstream>
#include <stdexcept>

#include "msgs/clock.hpp"

namespace stillframe::faults {

namespace {

// Above the controller's, below the relay's: a plant does not wait for its controller.
constexpr int plant_priority = 60;

std::string program(const char* name) { return std::string(STILLFRAME_BIN_DIR) + "/" + name; }

std::string port_url(int number, int side) {
  return "udpm://239.255.76.67:" + std::to_string(7700 + 2 * number + side) + "?ttl=0";
}

std::filesystem::path named(const Workbench& bench, const std::string& what, int number) {
  return bench.folder() / (what + "-" + std::to_string(number));
}

}  // namespace

Rig::Rig(const Workbench& bench, const RigOptions& options)
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
  if (relay_.wait(condition, limit_s)) return;
  const std::string state = relay_.look([](const Trace& trace) {
    return trace.status() == nullptr ? "no word from the controller"
                                     : "the controller: " + trace.status()->text;
  });
  throw std::runtime_error("waited for " + what + " for " + std::to_string(limit_s) + " s; " +
                           state + "\nplant:\n" + plant_->said() + "controller:\n" +
                           controller_->said());
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

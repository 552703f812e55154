#include "tests/stalls/trials.hpp"

#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>

#include "msgs/clock.hpp"
#include "tests/faults/process.hpp"
#include "tests/stalls/watcher.hpp"

namespace stillframe::stalls {

namespace fs = std::filesystem;
using faults::Process;
using stillframe_msgs::controller_status_t;

namespace {

constexpr const char* url = "udpm://239.255.76.67:7790?ttl=0";
constexpr double limit_s = 30;  // a machine that takes longer has lost a process
constexpr int plant_priority = 60;
// As quick as a policy may be, so that many trials take little time.
constexpr const char* policy =
    "start: on_request\narming: {duration_s: 0.2}\nramp: {in_s: 0.1, out_s: 0.1}\n"
    "measurements: {fade_s: 0.2}\nrejoin: {a_minute: 1000}\n";

std::string program(const char* name) { return std::string(STILLFRAME_BIN_DIR) + "/" + name; }

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) / ns_per_s;
}

class Bench {
 public:
  Bench(faults::Workbench& bench, const Stall& stall, const BatchOptions& options)
      : bench_(bench),
        stall_(stall),
        options_(options),
        random_(options.seed),
        folder_(bench.folder() / ("stalls-" + std::to_string(options.seed))),
        made_(fs::create_directories(folder_)),
        terminal_(stall.reader, folder_),
        watcher_(url) {
    // An older program may not know the bound.
    std::ofstream(folder_ / "policy.yaml")
        << policy << "flight_record: {duration_s: 1" << (is_ours() ? ", most_files: 1}\n" : "}\n");
    std::ofstream(folder_ / "disk") << stall.disk;
  }
  ~Bench() {
    std::ofstream(folder_ / "disk") << "works";
    for (auto* process : {&another_, &controller_, &plant_}) process->reset();
    fs::remove_all(folder_);
  }

  Batch run() {
    batch_.stall = stall_.name;
    try {
      begin();
      for (int i = 0; i + 1 < options_.n_trials; ++i) ask();
      if (stall_.handed_over) {
        hand_over();
      } else {
        refuse_another();
        end();
        count_records();
      }
    } catch (const std::exception& error) {
      fail(error.what());
    }
    batch_.n_commands = watcher_.n_commands();
    batch_.n_two_forces = watcher_.n_two_forces();
    if (batch_.n_commands == 0) fail("there was no command");
    if (batch_.n_two_forces > 0) {
      fail(std::to_string(batch_.n_two_forces) + " samples with two forces");
    }
    return batch_;
  }

 private:
  bool is_ours() const { return options_.controller.empty(); }

  void fail(const std::string& text) { batch_.failures.push_back(stall_.name + ": " + text); }

  std::vector<std::string> controller_command() const {
    return {"env",
            "LD_PRELOAD=" STALLED_DISK,
            "STILLFRAME_TEST_DISK=" + (folder_ / "disk").string(),
            is_ours() ? program("stillframe-controller") : options_.controller.string(),
            "--gains",
            bench_.gains(),
            "--lcm-url",
            url,
            "--policy",
            folder_ / "policy.yaml",
            "--flight-folder",
            folder_};
  }

  void begin() {
    plant_ = std::make_unique<Process>(
        std::vector<std::string>{program("stillframe-plant"), bench_.scene(), "--gains",
                                 bench_.gains(), "--mode", "wall_clock", "--duration", "200",
                                 "--lcm-url", url},
        folder_ / "plant.txt", plant_priority);
    auto command = controller_command();
    if (is_ours()) {
      command.insert(command.end(), {"--latch", folder_ / "latch.yaml"});
    }
    controller_ = std::make_unique<Process>(command, terminal_.name());
    require(watcher_.wait(
                pid(), [](const auto&) { return true; }, limit_s),
            "it said nothing");
    terminal_.begin();
    start();
  }

  std::int32_t pid() const { return controller_->pid(); }

  void require(bool condition, const char* text) const {
    if (!condition) throw std::runtime_error(text);
  }

  void ctl(const char* verb) const {
    Process ctl({program("stillframe"), "ctl", verb, "--lcm-url", url, "--timeout", "20"},
                folder_ / "ctl.txt");
    if (const auto code = ctl.wait(limit_s); code != 0) {
      throw std::runtime_error(std::string("ctl ") + verb + ": " + ctl.said());
    }
  }

  void start() {
    ctl("start");
    require(watcher_.wait(pid(), is_active, limit_s), "it did not get active again");
  }
  static bool is_active(const controller_status_t& status) {
    return status.state == controller_status_t::ACTIVE;
  }
  static bool is_idle(const controller_status_t& status) {
    return status.state == controller_status_t::IDLE;
  }

  void pass(double longest_s) {
    const auto most = static_cast<std::uint64_t>(longest_s * ns_per_s);
    sleep_until(monotonic_ns() + static_cast<std::int64_t>(random_() % most));
  }

  /// Answers when it went on; now if it was not suspended.
  std::int64_t stall() {
    pass(0.05);
    if (!stall_.suspended) return monotonic_ns();
    controller_->suspend();
    pass(0.3);
    const std::int64_t now = monotonic_ns();
    controller_->signal(SIGCONT);
    return now;
  }

  void ask() {
    // A stop of a loop that is faulted already would be told by nothing.
    const std::int64_t went_on = stall();
    watcher_.begin_stop(pid());
    ctl("stop");
    judge(std::max(went_on, watcher_.stop_heard_ns()));
    require(watcher_.wait(pid(), is_idle, limit_s), "it did not get idle");
    start();
  }

  void judge(std::int64_t asked_ns) {
    const Stop stop = watcher_.stop(limit_s);
    const std::int64_t now = monotonic_ns();
    const Trial trial{.obeyed_s = seconds(asked_ns, stop.obeyed_ns == 0 ? now : stop.obeyed_ns),
                      .told_s = seconds(asked_ns, stop.told_ns == 0 ? now : stop.told_ns),
                      .machine_s = bench_.bystander().worst_s(asked_ns, now)};
    batch_.trials.push_back(trial);
    if (std::max(trial.obeyed_s, trial.told_s) - trial.machine_s > longest_s) {
      fail("a stop was obeyed after " + std::to_string(trial.obeyed_s) + " s and told after " +
           std::to_string(trial.told_s) + " s; the machine was late by " +
           std::to_string(trial.machine_s) + " s");
    }
  }

  void start_another() {
    another_ = std::make_unique<Process>(controller_command(), folder_ / "another.txt");
  }

  void refuse_another() {
    start_another();
    if (another_->wait(limit_s) != 3) fail("a second controller was not refused");
  }

  void end() {
    stall();
    watcher_.begin_stop(pid());
    const std::int64_t asked_ns = monotonic_ns();
    controller_->signal(SIGTERM);
    judge(asked_ns);
    if (!controller_->wait(limit_s)) fail("SIGTERM did not end it");
  }

  /// Each suspension was a fault, with a record; one may be kept.
  void count_records() {
    int n = 0;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      n += entry.path().extension() == ".lcm" ? 1 : 0;
    }
    const int least = stall_.suspended && stall_.disk.empty() ? 1 : 0;
    if (is_ours() && (n < least || n > 1)) fail(std::to_string(n) + " flight records were kept");
  }

  /// The second one takes the frame while the first stands still; one of them has to give way.
  void hand_over() {
    controller_->suspend();
    start_another();
    const std::int32_t other = another_->pid();
    require(watcher_.wait(
                other, [](const auto&) { return true; }, limit_s),
            "no second one");
    ctl("start");
    require(watcher_.wait(other, is_active, limit_s), "the second one did not get active");
    controller_->signal(SIGCONT);
    if (controller_->wait(limit_s) != 3) fail("the first controller did not give way");
    if (!is_active(watcher_.status(other).value())) fail("the second one did not hold the frame");
  }

  faults::Workbench& bench_;
  const Stall& stall_;
  const BatchOptions& options_;
  std::mt19937_64 random_;
  fs::path folder_;
  bool made_;
  Terminal terminal_;
  Watcher watcher_;
  std::unique_ptr<Process> plant_, controller_, another_;
  Batch batch_;
};

}  // namespace

std::vector<Stall> all_stalls() {
  return {{.name = "nothing"},
          {.name = "a stopped terminal (Ctrl-S)", .reader = Reader::none},
          {.name = "a terminal of 100 characters a second", .reader = Reader::slow},
          {.name = "a full pipe", .reader = Reader::full},
          {.name = "a pipe without a reader", .reader = Reader::gone},
          {.name = "a disk that hangs", .disk = "hangs", .suspended = true},
          {.name = "a full disk", .disk = "full", .suspended = true},
          {.name = "SIGSTOP for up to 0.3 s", .suspended = true},
          {.name = "SIGSTOP while another controller comes", .handed_over = true},
          {.name = "a stopped terminal and a disk that hangs",
           .reader = Reader::none,
           .disk = "hangs",
           .suspended = true}};
}

Batch run_batch(faults::Workbench& bench, const Stall& stall, const BatchOptions& options) {
  return Bench(bench, stall, options).run();
}

}  // namespace stillframe::stalls

#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/faults/process.hpp"
#include "tests/faults/relay.hpp"
#include "tests/faults/workbench.hpp"

namespace stillframe::faults {

/// The machine stood still so often that nothing can be said of a controller.
struct MachineTrouble : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RigOptions {
  int number = 0;                              ///< of the rigs of one network: which ports it takes
  std::vector<std::string> controller_prefix;  ///< of the controller's command line
  std::string policy;                          ///< text of a policy file; empty: the defaults
};

/// One plant, one controller and the relay between them, on ports of their own.
class Rig {
 public:
  Rig(Workbench& bench, const RigOptions& options);

  void start_plant();
  void start_controller();
  /// Another controller on the same bus.
  std::unique_ptr<Process> another_controller();

  Process& plant() { return *plant_; }
  Process& controller() { return *controller_; }
  Relay& relay() { return relay_; }

  /// Waits until the newest sample is at least `sample`. Errors: std::runtime_error.
  void wait_for_sample(std::int64_t sample);
  /// Waits for so many samples more.
  void wait_samples(std::int64_t n);
  /// Waits until a condition holds, and longer where the machine stands still again and again: a
  /// loop needs three seconds in a row to come back. Errors: std::runtime_error that says what did
  /// not happen, what the machine did and what the controller says of itself; MachineTrouble where
  /// it is the machine's.
  void wait(const std::string& what, const std::function<bool(const Trace&)>& condition);
  /// Requests something (control_request_t) and waits until the controller has heard it.
  void ask(std::int32_t request);

  /// Ends the run as a user does, by SIGTERM to the plant. Answers the controller's exit code,
  /// nothing if it did not end.
  std::optional<int> end();

 private:
  std::vector<std::string> controller_command() const;
  std::string url(int side) const;

  /// s; a machine that takes longer has lost the process, and not only been slow.
  static constexpr double limit_s = 30;
  /// So often is that waited for on a machine that stands still meanwhile.
  static constexpr int most_waits = 4;

  Workbench& bench_;
  RigOptions options_;
  std::int64_t nonce_ = 0;
  Relay relay_;
  std::unique_ptr<Process> plant_, controller_;
};

}  // namespace stillframe::faults

#pragma once

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "controller/answer.hpp"
#include "controller/gains.hpp"
#include "tests/controller/child_process.hpp"
#include "tests/controller/fake_plant.hpp"
#include "tests/controller/toy_plant.hpp"

// The controller program against a fake plant, over LCM. Run through scripts/private_network.
namespace stillframe::controller {

using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_state_t;
using test::ChildProcess;

inline const std::string program = std::string(STILLFRAME_BIN_DIR) + "/stillframe-controller";

/// A plant, or a converter, does not wait for its controller (49, its way to the bus 48) nor for
/// whatever else a machine computes: at this real-time priority, where that is allowed.
constexpr int plant_priority = 60;

class ControllerProcess : public testing::Test {
 protected:
  ControllerProcess() {
    // Before there is a plant, whose threads take it over.
    const sched_param parameters{.sched_priority = plant_priority};
    sched_setscheduler(0, SCHED_FIFO, &parameters);
    static int n = 0;
    folder = std::filesystem::path(testing::TempDir()) /
             ("stillframe_controller_" + std::to_string(getpid()) + "_" + std::to_string(++n));
    std::filesystem::create_directories(folder);
    gains_file = folder / "gains.yaml";
  }
  ~ControllerProcess() override { std::filesystem::remove_all(folder); }

  /// Writes the gains and gives the command line to run them.
  std::vector<std::string> command_line(const Gains& gains, std::vector<std::string> more = {}) {
    std::ofstream(gains_file) << to_yaml(gains);
    std::vector<std::string> all{program, "--gains", gains_file,           "--flight-folder",
                                 folder,  "--latch", folder / "latch.yaml"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::filesystem::path folder;
  std::string gains_file;
};

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The bytes that the law, run here, would send as the controller that was heard last.
class Reference {
 public:
  Reference(const Gains& gains, const toy::FakePlant& plant)
      : answer_(law_from_gains(gains), gains.force_limit_n, true), plant_(plant) {
    answer_.prepare(command_);
  }
  std::vector<std::uint8_t> operator()(const measurement_t& measurement) {
    answer_.answer(measurement, command_);
    command_.instance = plant_.states.back().instance;
    std::vector<std::uint8_t> bytes(static_cast<size_t>(command_.getEncodedSize()));
    command_.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
  }

 private:
  Answer answer_;
  const toy::FakePlant& plant_;
  command_t command_{};
};

}  // namespace stillframe::controller

#pragma once

#include "controller/rig/driver.hpp"
#include "controller/rig/simulated_plant.hpp"

namespace stillframe::controller {

/// A rig that is not there: SimulatedPlant by the clock of this machine. Option: floor_rms (m/s^2,
/// default 0.003).
class SimulatedIo : public Io {
 public:
  explicit SimulatedIo(const DriverSetting& setting);
  /// Of any plant; floor_rms: m/s^2.
  explicit SimulatedIo(SampledPlant plant, double floor_rms = 0.003);

  bool receive(Measurement& measurement) noexcept override;
  void send(const Command& command) noexcept override { force_ = command.force; }

 private:
  explicit SimulatedIo(SimulatedPlant plant, Eigen::Index n_legs);
  SimulatedPlant plant_;
  std::int64_t start_ns_, seq_ = -1;
  Eigen::VectorXd force_;
};

}  // namespace stillframe::controller

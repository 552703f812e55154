#pragma once

#include <vector>

#include "controller/io.hpp"

namespace stillframe::controller {

/// One signal of a rig: value = gain (reading - tare) of a channel, and of a command reading =
/// value / gain + tare.
struct Channel {
  Eigen::Index number = 0;  ///< of the driver's channels of this kind
  double gain = 1;  ///< SI unit per unit of the driver; negative where it is wired the other way
  double tare = 0;  ///< unit of the driver
};

/// The signals of a rig, each in the order of the gains and of the log.
struct Channels {
  std::vector<Channel> sigma, applied, force, floor, frame;
};

/// How many channels a driver needs for these: to the last that is named.
Eigen::Index n_channels(const std::vector<Channel>& channels);

/// An Io in SI units and in the order of the gains, over one in the units and the order of its
/// cables. Construction is set-up; the rest is hot.
class ScaledIo : public Io {
 public:
  /// io outlives it, and has all channels up to the last that is named.
  ScaledIo(Io& io, const Channels& channels);

  bool receive(Measurement& measurement) noexcept override;
  void send(const Command& command) noexcept override;
  void beat() noexcept override { io_.beat(); }
  void enable(bool on) noexcept override { io_.enable(on); }
  IoState state() const noexcept override { return io_.state(); }

 private:
  Io& io_;
  Channels channels_;
  Measurement raw_;
  Command command_;
};

}  // namespace stillframe::controller

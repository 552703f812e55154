#include "controller/rig/scaled_io.hpp"

#include <algorithm>
#include <utility>

namespace stillframe::controller {

namespace {

void scale(const std::vector<Channel>& channels, const Eigen::VectorXd& raw,
           Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Channel& channel = channels[i];
    values(static_cast<Eigen::Index>(i)) = channel.gain * (raw(channel.number) - channel.tare);
  }
}

}  // namespace

Eigen::Index n_channels(const std::vector<Channel>& channels) {
  Eigen::Index n = 0;
  for (const Channel& channel : channels) n = std::max(n, channel.number + 1);
  return n;
}

ScaledIo::ScaledIo(Io& io, const Channels& channels)
    : io_(io),
      channels_(channels),
      raw_(measurement_of(static_cast<Eigen::Index>(channels.sigma.size()),
                          n_channels(channels.floor), n_channels(channels.frame))),
      command_(command_of(static_cast<Eigen::Index>(channels.sigma.size()))) {}

bool ScaledIo::receive(Measurement& m) noexcept {
  if (!io_.receive(raw_)) return false;
  m.seq = raw_.seq;
  m.time_ns = raw_.time_ns;
  m.received_ns = raw_.received_ns;
  m.heard = raw_.heard;
  scale(channels_.sigma, raw_.sigma, m.sigma);
  scale(channels_.applied, raw_.applied, m.applied);
  scale(channels_.floor, raw_.floor, m.floor);
  scale(channels_.frame, raw_.frame, m.frame);
  return true;
}

void ScaledIo::send(const Command& command) noexcept {
  command_.seq = command.seq;
  command_.time_ns = command.time_ns;
  command_.saturated = command.saturated;
  for (std::size_t i = 0; i < channels_.force.size(); ++i) {
    const Channel& channel = channels_.force[i];
    command_.force(channel.number) =
        command.force(static_cast<Eigen::Index>(i)) / channel.gain + channel.tare;
  }
  io_.send(command_);
}

}  // namespace stillframe::controller

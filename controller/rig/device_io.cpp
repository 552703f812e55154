#include "controller/rig/device_io.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cmath>

#include "core/errors/input_error.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

// Both ways, so that a pipe does not end when the program at its other end begins anew.
int open_device(const DriverSetting& setting, const std::string& option) {
  const std::string path = (setting.folder / setting.option(option)).string();
  const int file = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (file < 0) throw InputError("driver: " + option + ": " + path + ": " + std::strerror(errno));
  return file;
}

std::size_t n_words(Eigen::Index n) { return static_cast<std::size_t>(n) + 3; }

}  // namespace

DeviceIo::DeviceIo(const DriverSetting& setting)
    : in_(open_device(setting, "from")),
      out_(open_device(setting, "to")),
      search_(mark_samples, n_words(2 * setting.n_legs + setting.n_floor + setting.n_frame)),
      command_(n_words(setting.n_legs + 1)) {
  command_.front() = mark_commands;
}

DeviceIo::~DeviceIo() {
  close(in_);
  close(out_);
}

bool DeviceIo::receive(Measurement& m) noexcept {
  std::span<const std::uint32_t> frame = search_.next();
  if (frame.empty()) {
    const std::span<std::uint8_t> room = search_.room();
    const ssize_t n = read(in_, room.data(), room.size());
    if (n > 0) search_.filled(static_cast<std::size_t>(n));
    frame = search_.next();
    n_bad_ = search_.n_skipped();
    if (frame.empty()) return false;
  }
  // The number of 32 bits goes on where the one before was, forwards or back.
  const auto step = static_cast<std::int32_t>(frame[1] - static_cast<std::uint32_t>(seq_));
  seq_ += step;
  m.seq = seq_;
  m.received_ns = monotonic_ns();
  const std::uint32_t* word = &frame[2];
  for (Eigen::VectorXd* values : {&m.sigma, &m.applied, &m.floor, &m.frame}) {
    for (double& value : *values) value = static_cast<std::int32_t>(*word++);
  }
  number_ = frame[1];
  return true;
}

void DeviceIo::send(const Command& command) noexcept {
  for (Eigen::Index leg = 0; leg < command.force.size(); ++leg) {
    const double count = std::clamp(std::round(command.force(leg)), -2147483647.0, 2147483647.0);
    command_[static_cast<std::size_t>(leg) + 3] =
        static_cast<std::uint32_t>(static_cast<std::int32_t>(count));
  }
  sent_ = true;
  beat();
}

// Before the command of a period, and once more with it: the later one counts.
void DeviceIo::beat() noexcept {
  command_[1] = number_;
  command_.back() = sum_of(std::span(command_).first(command_.size() - 1));
  const auto size = static_cast<ssize_t>(4 * command_.size());
  if (write(out_, command_.data(), static_cast<std::size_t>(size)) != size) ++n_dropped_;
}

void DeviceIo::enable(bool on) noexcept { command_[2] = on ? 1 : 0; }

}  // namespace stillframe::controller

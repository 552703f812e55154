#include "controller/rig/device_io.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cmath>

#include "controller/realtime.hpp"
#include "core/errors/input_error.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

// Both ways, so that a pipe does not end when the program at its other end begins anew.
int open_device(const DriverSetting& setting, const std::string& option) {
  const std::string path = (setting.folder / setting.option(option)).lexically_normal().string();
  const int file = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (file < 0) setting.fail(option, "'" + path + "' cannot be opened: " + std::strerror(errno));
  return file;
}

constexpr std::size_t n_measurements = 4096;
constexpr int look_up_ms = 50;  // between looks at the stop flag
constexpr std::int64_t pause_ns = 1'000'000;

std::size_t n_words(Eigen::Index n) { return static_cast<std::size_t>(n) + 3; }

}  // namespace

DeviceIo::DeviceIo(const DriverSetting& setting)
    : in_(open_device(setting, "from")),
      out_(open_device(setting, "to")),
      search_(mark_samples, n_words(2 * setting.n_legs + setting.n_floor + setting.n_frame)),
      measurements_(n_measurements,
                    measurement_of(setting.n_legs, setting.n_floor, setting.n_frame)),
      command_(n_words(setting.n_legs + 1)),
      reader_([this] { read_on(); }) {
  command_.front() = mark_commands;
}

DeviceIo::~DeviceIo() {
  stop_ = true;
  reader_.join();
  close(in_);
  close(out_);
}

void DeviceIo::read_on() noexcept {
  prepare_servant({});
  // What has waited in the device is of before.
  for (auto room = search_.room(); read(in_, room.data(), room.size()) > 0;) {
  }
  while (!stop_) {
    pollfd ready{.fd = in_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, look_up_ms) <= 0) continue;
    const std::span<std::uint8_t> room = search_.room();
    const ssize_t n = read(in_, room.data(), room.size());
    const std::int64_t now = monotonic_ns();
    if (n <= 0) {
      sleep_until(now + pause_ns);  // of a device that is broken, which poll says at once
      continue;
    }
    search_.filled(static_cast<std::size_t>(n));
    for (auto frame = search_.next(); !frame.empty(); frame = search_.next()) {
      take_frame(frame, now);
    }
  }
}

void DeviceIo::take_frame(std::span<const std::uint32_t> frame, std::int64_t now_ns) noexcept {
  // The number of 32 bits goes on where the one before was, forwards or back.
  seq_ += static_cast<std::int32_t>(frame[1] - static_cast<std::uint32_t>(seq_));
  number_ = frame[1];
  Measurement* place = measurements_.free_place();
  if (place == nullptr) {
    ++n_bad_;
    return;
  }
  place->seq = seq_;
  place->received_ns = now_ns;
  const std::uint32_t* word = &frame[2];
  for (Eigen::VectorXd* values : {&place->sigma, &place->applied, &place->floor, &place->frame}) {
    for (double& value : *values) value = static_cast<std::int32_t>(*word++);
  }
  measurements_.push();
}

void DeviceIo::send(const Command& command) noexcept {
  for (Eigen::Index leg = 0; leg < command.force.size(); ++leg) {
    const double count = std::clamp(std::round(command.force(leg)), -2147483647.0, 2147483647.0);
    command_[static_cast<std::size_t>(leg) + 3] =
        static_cast<std::uint32_t>(static_cast<std::int32_t>(count));
  }
  write_frame();
}

// Off has no command of its own behind it.
void DeviceIo::enable(bool on) noexcept {
  command_[2] = on ? 1 : 0;
  if (on) return;
  std::fill(command_.begin() + 3, command_.end() - 1, 0u);
  write_frame();
}

void DeviceIo::write_frame() noexcept {
  command_[1] = number_;
  command_.back() = sum_of(std::span(command_).first(command_.size() - 1));
  const auto size = static_cast<ssize_t>(4 * command_.size());
  if (write(out_, command_.data(), static_cast<std::size_t>(size)) != size) ++n_dropped_;
}

}  // namespace stillframe::controller

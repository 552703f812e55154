#pragma once

#include <atomic>
#include <thread>

#include "controller/rig/device_frames.hpp"
#include "controller/rig/driver.hpp"
#include "controller/ring.hpp"

namespace stillframe::controller {

/// Converters behind two devices of the operating system, character devices or pipes, that carry
/// device_frames. Options: from, to (paths; the same one if it goes both ways). A thread waits for
/// samples, since what the loop goes by is when they come and not when it looks. A device that is
/// not read does not hold up the loop: what it does not take is dropped, and counted. In a period
/// without a command nothing is sent, so that amplifiers hear that there is none.
class DeviceIo : public Io {
 public:
  /// Errors: InputError if a device cannot be opened.
  explicit DeviceIo(const DriverSetting& setting);
  ~DeviceIo() override;
  DeviceIo(const DeviceIo&) = delete;
  DeviceIo& operator=(const DeviceIo&) = delete;

  bool receive(Measurement& measurement) noexcept override {
    return measurements_.take(measurement);
  }
  void send(const Command& command) noexcept override;
  void enable(bool on) noexcept override;
  IoState state() const noexcept override {
    return {.n_bad = n_bad_ + search_.n_skipped(), .n_dropped = n_dropped_};
  }

 private:
  void read_on() noexcept;
  void write_frame() noexcept;
  void take_frame(std::span<const std::uint32_t> frame, std::int64_t now_ns) noexcept;

  int in_, out_;
  FrameSearch search_;
  Ring<Measurement> measurements_;
  std::vector<std::uint32_t> command_;
  std::int64_t seq_ = -1;
  std::atomic<std::uint32_t> number_{0};
  std::atomic<std::int64_t> n_bad_{0}, n_dropped_{0};
  std::atomic<bool> stop_{false};
  std::thread reader_;  ///< last, so that it begins when all else is there
};

}  // namespace stillframe::controller

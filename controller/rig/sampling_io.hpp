#pragma once

#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <span>
#include <thread>

#include "controller/rig/driver.hpp"
#include "controller/ring.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

/// An Io over converters that make their reader wait, for drivers: a thread of its own waits for a
/// sample, hands it to the loop, and writes what the loop has last commanded, which answers the
/// sample before, so that delay_samples is 1 however the loop jitters. Converters that hold what
/// was written never let go by themselves: where nothing is commanded for ten periods, the thread
/// fades to no force. It cannot where the program is killed. A header alone, since the library of a
/// driver has nothing of stillframe but headers.
class SamplingIo : public Io {
 public:
  bool receive(Measurement& measurement) noexcept override { return samples_.take(measurement); }
  void send(const Command& command) noexcept override {
    if (!commands_.give(command)) ++n_dropped_;
  }
  IoState state() const noexcept override {
    return {.n_bad = n_bad_, .n_dropped = n_dropped_, .failed = failed_};
  }

 protected:
  enum class Wait { sample, none, failed };

  /// idle: what is written for no force, in the unit of the driver.
  explicit SamplingIo(const DriverSetting& setting, double idle = 0)
      : idle_(idle),
        patience_ns_(std::llround(1e10 / setting.sample_rate_hz)),
        sample_(measurement_of(setting.n_legs, setting.n_floor, setting.n_frame)),
        readings_(static_cast<std::size_t>(setting.n_legs + setting.n_floor + setting.n_frame)),
        bytes_(8 * readings_.size()),
        samples_(4096, sample_),
        commands_(256, command_of(setting.n_legs)),
        command_(command_of(setting.n_legs)) {
    sample_.applied.setConstant(idle_);
    command_.force.setConstant(idle_);
  }

  /// The channels that options sigma, floor and frame list, in this order. Errors: InputError.
  template <class Item>
  static std::vector<Item> inputs(const DriverSetting& setting) {
    std::vector<Item> all = setting.list<Item>("sigma", setting.n_legs);
    for (const Item& more : setting.list<Item>("floor", setting.n_floor)) all.push_back(more);
    for (const Item& more : setting.list<Item>("frame", setting.n_frame)) all.push_back(more);
    return all;
  }

  /// Waits, for some 50 ms at most, for the inputs of a sample.
  virtual Wait wait_for_sample(std::span<double> readings) noexcept = 0;

  /// Writes forces, and puts what they have become by rounding and limits in their place; false if
  /// they were not taken.
  virtual bool write(std::span<double> force) noexcept = 0;

  /// wait_for_sample of a file that gives a whole number of type Word for each input, whole samples
  /// or parts of them.
  template <class Word>
  Wait wait_for(int file, std::span<double> readings) noexcept {
    pollfd ready{.fd = file, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, 50) <= 0) return Wait::none;
    const std::size_t n_bytes = readings.size() * sizeof(Word);
    const ssize_t n = ::read(file, &bytes_[n_read_], n_bytes - n_read_);
    if (n <= 0) return Wait::failed;
    n_read_ += static_cast<std::size_t>(n);
    if (n_read_ < n_bytes) return Wait::none;
    n_read_ = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      Word word;
      std::memcpy(&word, &bytes_[i * sizeof(Word)], sizeof(Word));
      readings[i] = static_cast<double>(word);
    }
    return Wait::sample;
  }

  /// Last in the constructor of a driver, and first in its destructor.
  void start() {
    thread_ = std::thread([this] { run(); });
  }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() noexcept {
    // As the threads of LCM: behind the loop and before ordinary programs, where that is allowed.
    const sched_param behind_the_loop{.sched_priority = 48};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &behind_the_loop);
    std::int64_t heard_ns = monotonic_ns() - patience_ns_, before_ns = heard_ns;
    while (!stop_) {
      const Wait wait = failed_ ? Wait::failed : wait_for_sample(readings_);
      const std::int64_t now_ns = sample_.received_ns = monotonic_ns();
      const bool silent = now_ns - heard_ns >= patience_ns_;
      sample_.heard = !silent;
      if (wait == Wait::sample) {
        auto reading = readings_.begin();
        for (Eigen::VectorXd* values : {&sample_.sigma, &sample_.floor, &sample_.frame})
          for (double& value : *values) value = *reading++;
        if (!samples_.give(sample_)) ++n_bad_;
        ++sample_.seq;
      } else if (wait == Wait::failed) {
        failed_ = true;
        sleep_until(now_ns + 1'000'000);
      }
      if (commands_.oldest() != nullptr) {
        while (commands_.take(command_)) {
        }
        heard_ns = now_ns;
      } else if (silent) {
        const double kept = std::exp(static_cast<double>(before_ns - now_ns) / 1e8);  // 0.1 s
        command_.force = (kept * (command_.force.array() - idle_) + idle_).matrix();
      }
      before_ns = now_ns;
      put();
    }
    command_.force.setConstant(idle_);
    put();
  }
  void put() noexcept {
    sample_.applied = command_.force;
    const auto n = static_cast<std::size_t>(sample_.applied.size());
    if (!write({sample_.applied.data(), n})) ++n_dropped_;
  }

  const double idle_;
  const std::int64_t patience_ns_;
  Measurement sample_;
  std::vector<double> readings_;
  std::vector<unsigned char> bytes_;  // of a sample that comes in parts
  std::size_t n_read_ = 0;
  Ring<Measurement> samples_;
  Ring<Command> commands_;
  Command command_;
  std::atomic<std::int64_t> n_bad_{0}, n_dropped_{0};
  std::atomic<bool> failed_{false}, stop_{false};
  std::thread thread_;
};

}  // namespace stillframe::controller

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <mutex>

#include "controller/rig/sampling_io.hpp"

namespace stillframe::controller {
namespace {

DriverSetting two_legs(double sample_rate_hz) {
  DriverSetting setting;
  setting.n_legs = 2;
  setting.n_frame = 1;
  setting.sample_rate_hz = sample_rate_hz;
  return setting;
}

/// Its samples are what the test writes into a pipe, its forces whole numbers up to 100.
class PipeIo : public SamplingIo {
 public:
  explicit PipeIo(double sample_rate_hz = 1000) : SamplingIo(two_legs(sample_rate_hz), 7) {
    EXPECT_EQ(pipe(ends_.data()), 0);
    start();
  }
  ~PipeIo() override {
    stop();
    end();
    close(ends_[0]);
    written_at_last = written();
  }
  void give(std::span<const std::int16_t> words) {
    EXPECT_EQ(::write(ends_[1], words.data(), words.size_bytes()),
              static_cast<ssize_t>(words.size_bytes()));
  }
  void end() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  std::array<double, 2> written() {
    const std::lock_guard lock(mutex_);
    return written_;
  }
  /// Waits for a sample, for seconds at most.
  bool wait(Measurement& sample) {
    for (int i = 0; i < 5000; ++i) {
      if (receive(sample)) return true;
      sleep_until(monotonic_ns() + 1'000'000);
    }
    return false;
  }
  static inline std::array<double, 2> written_at_last{};

 private:
  Wait wait_for_sample(std::span<double> readings) noexcept override {
    return wait_for<std::int16_t>(ends_[0], readings);
  }
  bool write(std::span<double> force) noexcept override {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < 2; ++i)
      written_[i] = force[i] = std::min(std::round(force[i]), 100.0);
    return true;
  }

  std::array<int, 2> ends_{};
  std::mutex mutex_;
  std::array<double, 2> written_{};
};

Command of(double first, double second) {
  Command command = command_of(2);
  command.force << first, second;
  return command;
}

TEST(SamplingIo, HandsOnSamplesAndWhatHadBeenWritten) {
  PipeIo io(10);  // it does not let go within a second, however this machine stalls
  Measurement sample = measurement_of(2, 0, 1);
  const std::array<std::int16_t, 6> two{1, -2, 3, 4, 5, -6};
  io.give(std::span(two).first(2));  // a part of a sample is none
  io.send(of(10.4, 200));
  sleep_until(monotonic_ns() + 100'000'000);
  EXPECT_FALSE(io.receive(sample));
  const std::int64_t before = monotonic_ns();
  io.send(of(20.6, 200));
  io.give(std::span(two).subspan(2, 1));
  ASSERT_TRUE(io.wait(sample));
  EXPECT_EQ(sample.seq, 0);
  EXPECT_GE(sample.received_ns, before);
  EXPECT_EQ(sample.sigma, Eigen::Vector2d(1, -2));
  EXPECT_EQ(sample.frame(0), 3);
  EXPECT_LE(sample.applied(1), 100);  // as the converter has it, not as it was commanded
  io.give(std::span(two).last(3));
  ASSERT_TRUE(io.wait(sample));
  EXPECT_EQ(sample.seq, 1);
  EXPECT_EQ(sample.sigma, Eigen::Vector2d(4, 5));
  EXPECT_EQ(sample.applied, Eigen::Vector2d(21, 100));
  EXPECT_TRUE(sample.heard);
  EXPECT_EQ(io.state().n_bad + io.state().n_dropped, 0);
}

/// The converters hold what was written: without commands the thread lets go, with a time constant
/// of 0.1 s, with samples or without.
TEST(SamplingIo, LetsGoWhereNothingIsCommanded) {
  {
    PipeIo io;
    Measurement sample = measurement_of(2, 0, 1);
    const std::array<std::int16_t, 3> one{1, 2, 3};
    io.give(one);
    ASSERT_TRUE(io.wait(sample));
    EXPECT_FALSE(sample.heard);
    EXPECT_EQ(sample.applied, Eigen::Vector2d(7, 7));
    io.send(of(90, -90));
    sleep_until(monotonic_ns() + 2'000'000'000);
    EXPECT_EQ(io.written(), (std::array{7.0, 7.0}));
    io.give(one);
    ASSERT_TRUE(io.wait(sample));
    EXPECT_FALSE(sample.heard);
    io.send(of(50, 50));
  }
  EXPECT_EQ(PipeIo::written_at_last, (std::array{7.0, 7.0}));
}

TEST(SamplingIo, SaysThatNothingWillCome) {
  PipeIo io;
  EXPECT_FALSE(io.state().failed);
  io.end();
  for (int i = 0; i < 5000 && !io.state().failed; ++i) sleep_until(monotonic_ns() + 1'000'000);
  EXPECT_TRUE(io.state().failed);
}

TEST(DriverOptions, ListChannels) {
  DriverSetting setting;
  setting.options = {{"sigma", "2 0  1"}, {"names", "a b"}};
  EXPECT_EQ(setting.list<int>("sigma", 3), (std::vector{2, 0, 1}));
  EXPECT_EQ(setting.list<std::string>("names", 2), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(setting.list<int>("nothing", 0).empty());
  EXPECT_THROW(setting.list<int>("sigma", 2), InputError);
  EXPECT_THROW(setting.list<int>("names", 2), InputError);
  EXPECT_THROW(setting.list<int>("nothing", 1), InputError);
}

}  // namespace
}  // namespace stillframe::controller

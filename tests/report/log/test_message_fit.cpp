// The lengths in a payload are checked before lcm-gen's decoders believe them.
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "report/log/log_events.hpp"
#include "stillframe_msgs/clock_exchange_t.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::report {
namespace {

using namespace stillframe_msgs;

// Every list and text of a type, filled to a size.

void fill(measurement_t& m, std::size_t n) {
  const std::vector<double> values(n, 1.5);
  m.n_floor = m.n_legs = m.n_frame = static_cast<int>(n);
  m.floor_acceleration = m.sigma = m.applied_force = m.frame_acceleration = values;
}
void fill(command_t& m, std::size_t n) {
  m.n_legs = static_cast<int>(n);
  m.force.assign(n, 2.5);
}
void fill(run_info_t& m, std::size_t n) {
  const std::string text(n, 'x');
  m.program_version = m.scene_name = m.scene_hash = m.scene_text = text;
  m.floor_text = m.gains_text = m.mode = m.loop = text;
  m.n_floor = m.n_legs = m.n_frame = static_cast<int>(n);
  m.floor_names = m.leg_names = m.frame_names = std::vector<std::string>(n, text);
}
void fill(run_state_t& m, std::size_t n) { m.source = m.text = std::string(n, 'x'); }
void fill(timing_t& m, std::size_t n) { m.source = std::string(n, 'x'); }
void fill(control_request_t&, std::size_t) {}
void fill(controller_status_t& m, std::size_t n) { m.text = m.answer = std::string(n, 'x'); }
void fill(loop_records_t& m, std::size_t n) {
  loop_record_t record{};
  record.n_legs = static_cast<int>(n);
  record.sigma = record.applied = record.force = std::vector<double>(n, 3.5);
  m.n_records = static_cast<int>(n);
  m.records.assign(n, record);
}
void fill(loop_checkpoint_t& m, std::size_t n) {
  m.policy_text = std::string(n, 'x');
  m.n = static_cast<int>(n);
  m.memory.assign(n, 4.5);
}
void fill(excitation_t& m, std::size_t n) {
  m.n_legs = static_cast<int>(n);
  m.force.assign(n, 5.5);
}
void fill(clock_exchange_t& m, std::size_t n) { m.asked_ns = static_cast<std::int64_t>(n); }

template <typename Message>
class MessageFit : public ::testing::Test {
 protected:
  static std::string encoded(std::size_t n) {
    Message message{};
    fill(message, n);
    std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
    EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())),
              static_cast<int>(bytes.size()));
    return bytes;
  }
};

using Types = ::testing::Types<measurement_t, command_t, run_info_t, run_state_t, timing_t,
                               control_request_t, controller_status_t, loop_records_t,
                               loop_checkpoint_t, excitation_t, clock_exchange_t>;
TYPED_TEST_SUITE(MessageFit, Types);

TYPED_TEST(MessageFit, WhatLcmEncodesFitsAndComesBack) {
  for (const std::size_t n : {0u, 1u, 2u, 6u, 18u}) {
    const std::string bytes = this->encoded(n);
    EXPECT_EQ(fit<TypeParam>(bytes), Fit::whole) << n;
    TypeParam message;
    fill(message, 3);
    ASSERT_TRUE(decode(bytes, message));
    std::string again(static_cast<std::size_t>(message.getEncodedSize()), '\0');
    message.encode(again.data(), 0, static_cast<int>(again.size()));
    EXPECT_EQ(again, bytes);
  }
}

TYPED_TEST(MessageFit, AnotherLengthDoesNotFit) {
  const std::string bytes = this->encoded(6);
  TypeParam message;
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_EQ(fit<TypeParam>(bytes.substr(0, n)), Fit::damaged) << n;
    EXPECT_FALSE(decode(bytes.substr(0, n), message));
  }
  EXPECT_EQ(fit<TypeParam>(bytes + '\0'), Fit::damaged);
  EXPECT_EQ(fit<TypeParam>(""), Fit::damaged);
  EXPECT_EQ(fit<TypeParam>(std::string(bytes.size(), '\0')), Fit::damaged);
}

TYPED_TEST(MessageFit, AnotherFingerprintIsAnotherVersion) {
  const std::string bytes = this->encoded(2);
  for (std::size_t byte = 0; byte < 8; ++byte) {
    std::string other = bytes;
    other[byte] = static_cast<char>(other[byte] ^ 0x10);
    EXPECT_EQ(fit<TypeParam>(other), Fit::other_version);
    EXPECT_EQ(fit<TypeParam>(other + "more"), Fit::other_version);
  }
}

/// Whatever passes is decoded without an exception and takes no more than its bytes. 0x7FFFFFFF and
/// 0x80000000 are what lcm-gen's decoders cannot stand.
TYPED_TEST(MessageFit, NoLengthIsBelieved) {
  const std::string bytes = this->encoded(3);
  for (std::size_t at = 8; at + 4 <= bytes.size(); ++at) {
    for (const std::uint32_t value : {0u, 1u, 4u, 0x10000000u, 0x7FFFFFFFu, 0x80000000u, ~0u}) {
      std::string other = bytes;
      for (std::size_t i = 0; i < 4; ++i) {
        other[at + i] = static_cast<char>(value >> (24 - 8 * i));
      }
      TypeParam message;
      bool whole = false;
      EXPECT_NO_THROW(whole = decode(other, message)) << at << " " << value;
      if (!whole) continue;
      EXPECT_EQ(message.getEncodedSize(), static_cast<int>(other.size()));
    }
  }
}

TYPED_TEST(MessageFit, RubbishBehindTheFingerprintIsHarmless) {
  std::mt19937_64 random(5);
  const std::string bytes = this->encoded(3);
  TypeParam message;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string other = bytes.substr(0, 8) + std::string(random() % 400, '\0');
    for (std::size_t i = 8; i < other.size(); ++i) {
      other[i] = static_cast<char>(random() % 4 == 0 ? random() : 0);
    }
    EXPECT_NO_THROW(decode(other, message));
  }
}

/// lcm-gen's decoders pass over a list of no entries, whatever was in it.
TEST(MessageDecode, NothingIsLeftOfTheMessageBefore) {
  measurement_t empty{}, message{};
  fill(message, 3);
  std::string bytes(static_cast<std::size_t>(empty.getEncodedSize()), '\0');
  empty.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  ASSERT_TRUE(decode(bytes, message));
  EXPECT_TRUE(message.floor_acceleration.empty() && message.sigma.empty() &&
              message.applied_force.empty() && message.frame_acceleration.empty());
}

}  // namespace
}  // namespace stillframe::report

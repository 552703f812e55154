// Events of a log: the same as LCM's own reader finds, and what a broken file still gives.
#include <gtest/gtest.h>

#include "core/errors/input_error.hpp"
#include "report/log/event_file.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/log/log_bytes.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Seen = std::vector<std::tuple<std::int64_t, std::string, std::string>>;

class EventFileTest : public ::testing::Test {
 protected:
  test::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "a.lcm";

  template <typename Fill>
  std::string log(Fill&& fill) {
    {
      LogWriter writer(file_);
      fill(writer);
    }
    return bytes_of(file_);
  }

  LogDamage read(const std::string& bytes, Seen& seen) {
    write_bytes_to(file_, bytes);
    seen.clear();
    return for_each_event(file_, [&](const LogEvent& event) {
      seen.emplace_back(event.timestamp_us, event.channel, event.payload);
    });
  }
};

void fill_sizes(LogWriter& writer) {
  // Around the window of 1 MiB, so that events lie across its edges.
  for (const std::size_t size :
       {0u, 1u, 17u, 1'000'000u, 1'048'576u, 48'000u, 3'000'000u, 0u, 48'500u, 1'048'500u, 5u}) {
    writer.write_bytes("C" + std::to_string(size), std::vector<char>(size, char('a' + size % 26)));
  }
}

TEST_F(EventFileTest, SameEventsAsLcmsOwnReader) {
  log(fill_sizes);
  Seen seen;
  const LogDamage damage = read(bytes_of(file_), seen);
  const auto expected = events_by_lcm(file_);
  ASSERT_EQ(expected.size(), 11u);
  ASSERT_EQ(seen.size(), expected.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i],
              std::tuple(expected[i].timestamp_us, expected[i].channel, expected[i].payload));
  }
  EXPECT_EQ(damage.n_damaged + damage.skipped_bytes + damage.unread_bytes, 0);
}

TEST_F(EventFileTest, EveryCutLeavesTheEventsBeforeIt) {
  const std::string whole = log([](LogWriter& w) {
    for (const char* channel : {"A", "BB", "CCC"}) w.write_bytes(channel, {1, 2, 3});
  });
  const auto events = events_by_lcm(file_);
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    Seen seen;
    const LogDamage damage = read(whole.substr(0, cut), seen);
    std::size_t n = 0, end = 0;
    while (n < events.size() && events[n].end <= cut) end = events[n++].end;
    EXPECT_EQ(seen.size(), n) << cut;
    EXPECT_EQ(damage.unread_bytes, static_cast<std::int64_t>(cut - end)) << cut;
    EXPECT_EQ(damage.n_damaged + damage.skipped_bytes, 0) << cut;
  }
}

/// A length of 2 GB where there are 300 bytes: nothing is believed of it.
TEST_F(EventFileTest, ADamagedLengthCostsItsEventAlone) {
  const std::string whole = log([](LogWriter& w) {
    for (const char* channel : {"A", "B", "C", "D"}) w.write_bytes(channel, {1, 2, 3});
  });
  const auto events = events_by_lcm(file_);
  for (const std::size_t field : {20u, 24u}) {      // length of the channel, of the payload
    for (const unsigned char top : {0x7F, 0xFF}) {  // far too long, negative
      std::string bytes = whole;
      bytes[events[1].begin + field] = static_cast<char>(top);
      Seen seen;
      const LogDamage damage = read(bytes, seen);
      ASSERT_EQ(seen.size(), 3u);
      EXPECT_EQ(std::get<1>(seen[1]), "C");
      EXPECT_EQ(damage.n_damaged, 1);
      EXPECT_EQ(damage.skipped_bytes, static_cast<std::int64_t>(events[1].end - events[1].begin));
    }
  }
}

/// A length that ends exactly at the event after next takes the one between with it, unless the
/// numbers are looked at.
TEST_F(EventFileTest, ALengthThatEndsAtALaterEventIsNotBelieved) {
  const std::string whole = log([](LogWriter& w) {
    for (const char* channel : {"A", "B", "C", "D"}) w.write_bytes(channel, {1, 2, 3});
  });
  const auto events = events_by_lcm(file_);
  std::string bytes = whole;
  bytes[events[1].begin + 27] = static_cast<char>(3 + (events[2].end - events[2].begin));
  Seen seen;
  read(bytes, seen);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(std::get<1>(seen[0]) + std::get<1>(seen[1]) + std::get<1>(seen[2]), "ACD");
}

TEST_F(EventFileTest, ADamagedMarkOrNumberCostsNothing) {
  const std::string whole = log([](LogWriter& w) {
    for (const char* channel : {"A", "B", "C", "D"}) w.write_bytes(channel, {1, 2, 3});
  });
  const auto events = events_by_lcm(file_);
  for (std::size_t event = 1; event < 4; ++event) {
    for (std::size_t byte = 0; byte < 12; ++byte) {
      std::string bytes = whole;
      bytes[events[event].begin + byte] = static_cast<char>(bytes[events[event].begin + byte] ^ 64);
      Seen seen;
      EXPECT_EQ(read(bytes, seen).skipped_bytes, 0);
      EXPECT_EQ(seen.size(), 4u) << event << " " << byte;
    }
  }
}

TEST_F(EventFileTest, LogsThatWereJoinedAreOneLog) {
  const std::string first = log([](LogWriter& w) {
    for (const char* channel : {"A", "B"}) w.write_bytes(channel, {1, 2, 3});
  });
  const std::string second = log([](LogWriter& w) {
    for (const char* channel : {"C", "D"}) w.write_bytes(channel, {1, 2, 3});
  });
  Seen seen;
  const LogDamage damage = read(first + second, seen);
  EXPECT_EQ(seen.size(), 4u);
  EXPECT_EQ(damage.n_damaged + damage.unread_bytes, 0);
}

/// A log in a payload is a payload.
TEST_F(EventFileTest, MarksInsideAPayloadAreNoEvents) {
  const std::string inner = log([](LogWriter& w) {
    for (int i = 0; i < 20; ++i) w.write_bytes("INNER", {1, 2, 3});
  });
  log([&](LogWriter& w) {
    for (int i = 0; i < 3; ++i) w.write_bytes("FILE", {inner.begin(), inner.end()});
  });
  Seen seen;
  const LogDamage damage = read(bytes_of(file_), seen);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(std::get<2>(seen[1]), inner);
  EXPECT_EQ(damage.n_damaged, 0);
}

TEST_F(EventFileTest, APayloadThatIsTooLargeIsPassedOver) {
  log([](LogWriter& w) {
    w.write_bytes("BEFORE", {1});
    w.write_bytes("HUGE", std::vector<char>(LogEvent::largest_payload + 1, 'h'));
    w.write_bytes("BEHIND", {2});
  });
  std::vector<std::pair<std::string, std::size_t>> seen;
  for_each_event(file_, [&](const LogEvent& event) {
    seen.emplace_back(event.channel, event.payload.size());
  });
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[1], std::pair(std::string("HUGE"), std::size_t{0}));
  EXPECT_EQ(seen[2], std::pair(std::string("BEHIND"), std::size_t{1}));
}

/// Behind rubbish of about 1 MiB, what is read ahead, so that the mark lies across its edge.
TEST_F(EventFileTest, AMarkAcrossTheEdgeOfTheWindowIsFound) {
  const std::string whole = log([](LogWriter& w) { w.write_bytes("A", {1, 2, 3}); });
  for (std::size_t n = (1 << 20) - 6; n < (1 << 20) + 6; ++n) {
    Seen seen;
    const LogDamage damage = read(std::string(n, 'x') + whole, seen);
    EXPECT_EQ(seen.size(), 1u) << n;
    EXPECT_EQ(damage.skipped_bytes, static_cast<std::int64_t>(n));
  }
}

TEST_F(EventFileTest, FilesThatAreNoLogsHoldNothing) {
  Seen seen;
  EXPECT_EQ(read("", seen).unread_bytes, 0);
  EXPECT_EQ(read("not a log", seen).unread_bytes, 9);
  EXPECT_EQ(read(std::string(3'000'000, '\xED'), seen).unread_bytes, 3'000'000);
  EXPECT_TRUE(seen.empty());
  expect_error<InputError>([&] { EventFile(folder_ / "none"); }, "there is no such LCM log");
  expect_error<InputError>([&] { EventFile(folder_.path()); }, "there is no such LCM log");
}

}  // namespace
}  // namespace stillframe::report

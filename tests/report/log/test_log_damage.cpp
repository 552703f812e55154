// Damaged logs never crash, and all that is readable in them comes out with the bits it had.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"
#include "report/log/log_events.hpp"
#include "tests/report/log/log_bytes.hpp"
#include "tests/report/log/run_fixture.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Random = std::mt19937_64;

constexpr std::int64_t run_id = 42;

/// A file whose bytes know where they came from, -1 for those that were changed or made up.
struct Traced {
  std::string bytes;
  std::vector<std::int64_t> origin;

  explicit Traced(const std::string& log) : bytes(log), origin(log.size()) {
    std::iota(origin.begin(), origin.end(), 0);
  }
  std::size_t size() const { return bytes.size(); }
  void set(std::size_t at, char value) {
    if (bytes[at] == value) return;
    bytes[at] = value;
    origin[at] = -1;
  }
  void cut(std::size_t at) { bytes.resize(at), origin.resize(at); }
  void erase(std::size_t at, std::size_t n) {
    bytes.erase(at, n);
    origin.erase(origin.begin() + static_cast<long>(at),
                 origin.begin() + static_cast<long>(at + n));
  }
  void insert(std::size_t at, const std::string& what, const std::vector<std::int64_t>& from) {
    bytes.insert(at, what);
    origin.insert(origin.begin() + static_cast<long>(at), from.begin(), from.end());
  }
  void insert_new(std::size_t at, const std::string& what) {
    insert(at, what, std::vector<std::int64_t>(what.size(), -1));
  }
};

struct Stretch {
  std::size_t begin = 0, size = 0;
};

Stretch any_stretch(Random& random, std::size_t file_size, std::size_t longest) {
  const std::size_t size = 1 + random() % std::min(longest, file_size - 1);
  return {random() % (file_size - size), size};
}

// -- The kinds of damage
// ---------------------------------------------------------------------------

void cut(Traced& file, Random& random) { file.cut(random() % file.size()); }

void flip(Traced& file, Random& random) {
  const std::size_t at = random() % file.size();
  file.set(at, static_cast<char>(file.bytes[at] ^ (1 << random() % 8)));
}

void flip_many(Traced& file, Random& random) {
  for (int i = 0; i < 30; ++i) flip(file, random);
}

void rubbish(Traced& file, Random& random) {
  const Stretch s = any_stretch(random, file.size(), 3000);
  for (std::size_t i = 0; i < s.size; ++i) file.set(s.begin + i, static_cast<char>(random()));
}

void zero(Traced& file, Random& random) {
  const Stretch s = any_stretch(random, file.size(), 5000);
  for (std::size_t i = 0; i < s.size; ++i) file.set(s.begin + i, '\0');
}

void repeat_stretch(Traced& file, Random& random) {
  const Stretch s = any_stretch(random, file.size(), 20'000);
  const Traced before = file;
  const auto from = before.origin.begin() + static_cast<long>(s.begin);
  file.insert(random() % file.size(), before.bytes.substr(s.begin, s.size),
              {from, from + static_cast<long>(s.size)});
}

void move_stretch(Traced& file, Random& random) {
  const Stretch s = any_stretch(random, file.size(), 20'000);
  const Traced before = file;
  const auto from = before.origin.begin() + static_cast<long>(s.begin);
  file.erase(s.begin, s.size);
  file.insert(random() % file.size(), before.bytes.substr(s.begin, s.size),
              {from, from + static_cast<long>(s.size)});
}

void lose_stretch(Traced& file, Random& random) {
  const Stretch s = any_stretch(random, file.size(), 20'000);
  file.erase(s.begin, s.size);
}

void insert_rubbish(Traced& file, Random& random) {
  std::string made_up(1 + random() % 3000, '\0');
  for (char& byte : made_up) byte = static_cast<char>(random());
  file.insert_new(random() % file.size(), made_up);
}

/// As a machine leaves a file that it had made room for when it went down.
void zero_tail(Traced& file, Random& random) {
  cut(file, random);
  file.insert_new(file.size(), std::string(1 + random() % 100'000, '\0'));
}

/// Marks and lengths that promise anything.
void insert_false_headers(Traced& file, Random& random) {
  for (int i = 0; i < 20; ++i) {
    std::string header("\xED\xA1\xDA\x01", 4);
    while (header.size() < 28) header += static_cast<char>(random());
    if (random() % 2 == 0) header.replace(20, 4, std::string("\0\0\0\x0e", 4));
    if (random() % 2 == 0) header.replace(24, 2, std::string("\0\0", 2));
    file.insert_new(random() % file.size(), header);
  }
}

struct Damage {
  const char* name;
  void (*apply)(Traced&, Random&);
  int n_trials;
  std::uint64_t seed;
};

// -- What must come out
// ----------------------------------------------------------------------------

class LogDamageTest : public ::testing::Test {
 protected:
  explicit LogDamageTest(std::int64_t n_samples = 400) : n_samples_(n_samples) {
    Random random(20240229);
    {
      LogWriter log(folder_ / "whole.lcm");
      write_full_run(log, run_id, n_samples_, random);
    }
    whole_ = bytes_of(folder_ / "whole.lcm");
    events_ = events_by_lcm(folder_ / "whole.lcm");
    scan_log(folder_ / "whole.lcm", {}, reference_);
  }

  /// Events that are in the file whole, and behind which the file goes on as a log does.
  std::vector<bool> readable_events(const Traced& file) const {
    std::map<std::int64_t, std::vector<std::size_t>> places;  // of the first byte of each event
    std::map<std::int64_t, std::size_t> by_begin;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      by_begin[static_cast<std::int64_t>(events_[i].begin)] = i;
    }
    std::vector<bool> readable(events_.size(), false);
    for (std::size_t at = 0; at < file.size(); ++at) {
      const auto found = by_begin.find(file.origin[at]);
      if (found == by_begin.end()) continue;
      const LoggedEvent& event = events_[found->second];
      const std::size_t size = event.end - event.begin;
      if (at + size > file.size()) continue;
      bool is_whole = true;
      for (std::size_t i = 0; i < size && is_whole; ++i) {
        is_whole = file.origin[at + i] == static_cast<std::int64_t>(event.begin + i);
      }
      if (is_whole && goes_on(file, at + size, event)) readable[found->second] = true;
    }
    return readable;
  }

  static bool goes_on(const Traced& file, std::size_t end, const LoggedEvent& event) {
    const std::string mark("\xED\xA1\xDA\x01", 4);
    if (file.size() - end < 12) {
      const std::size_t n = std::min<std::size_t>(4, file.size() - end);
      return file.bytes.compare(end, n, mark, 0, n) == 0;
    }
    if (file.bytes.compare(end, 4, mark) == 0) return true;
    std::string number(8, '\0');
    for (int i = 0; i < 8; ++i) {
      number[static_cast<std::size_t>(i)] = static_cast<char>((event.number + 1) >> (56 - 8 * i));
    }
    return file.bytes.compare(end + 4, 8, number) == 0;
  }

  /// seq of the readable messages of a channel.
  std::vector<std::int64_t> readable_seq(const std::vector<bool>& readable,
                                         const std::string& channel) const {
    std::vector<std::int64_t> result;
    std::int64_t seq = 0;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      if (events_[i].channel != channel) continue;
      if (readable[i]) result.push_back(seq);
      ++seq;
    }
    return result;
  }

  void expect_sound(const Keeper& kept, const LogScan& scan, const std::vector<bool>& readable) {
    EXPECT_TRUE(kept.is_orderly);
    EXPECT_EQ(static_cast<std::int64_t>(kept.samples_by_seq.size()), scan.measurements.n_received);
    const std::int64_t end = std::max(scan.info.n_samples, kept.samples_by_seq.rbegin()->first + 1);
    EXPECT_EQ(scan.measurements.n_received + scan.measurements.n_lost, end);
    std::int64_t in_gaps = 0;
    for (const SequenceGap& gap : scan.measurements.gaps) in_gaps += gap.last - gap.first + 1;
    EXPECT_EQ(in_gaps, scan.measurements.n_lost);
    EXPECT_EQ(scan.n_too_late, 0);
    // Two of three copies outvote a damaged one.
    if (std::count(readable.begin(), readable.begin() + 3, true) >= 2) {
      EXPECT_EQ(kept.info.scene_text, reference_.info.scene_text);
      EXPECT_EQ(kept.info.n_samples, n_samples_);
    }

    for (const std::int64_t seq : readable_seq(readable, channels::measurement)) {
      const auto found = kept.samples_by_seq.find(seq);
      ASSERT_NE(found, kept.samples_by_seq.end()) << "readable sample " << seq << " did not come";
      const Keeper::Sample& a = found->second;
      const Keeper::Sample& b = reference_.samples_by_seq.at(seq);
      EXPECT_EQ(a.time_s, b.time_s);
      EXPECT_TRUE(a.floor == b.floor && a.sigma == b.sigma && a.applied == b.applied &&
                  a.frame == b.frame)
          << "sample " << seq;
    }
    for (const std::int64_t seq : readable_seq(readable, channels::command)) {
      const auto found = kept.samples_by_seq.find(seq);
      if (found == kept.samples_by_seq.end()) continue;
      EXPECT_EQ(found->second.command, reference_.samples_by_seq.at(seq).command);
    }
  }

  /// Every byte is part of an event, skipped, or unread.
  void expect_all_bytes_counted(const std::filesystem::path& file) {
    std::int64_t n = 0;
    const LogDamage damage = for_each_event(file, [&](const LogEvent& event) {
      n += 28 + static_cast<std::int64_t>(event.channel.size() + event.payload.size());
    });
    EXPECT_EQ(n + damage.skipped_bytes + damage.unread_bytes,
              static_cast<std::int64_t>(std::filesystem::file_size(file)));
  }

  std::int64_t n_samples_;
  test::ScratchFolder folder_;
  std::string whole_;
  std::vector<LoggedEvent> events_;
  Keeper reference_;
};

class KindOfDamage : public LogDamageTest, public ::testing::WithParamInterface<Damage> {};

long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST_P(KindOfDamage, WhatIsReadableComesOutBitForBit) {
  ASSERT_EQ(reference_.samples_by_seq.size(), static_cast<std::size_t>(n_samples_));
  const Damage& damage = GetParam();
  Random random(damage.seed);
  const std::filesystem::path file = folder_ / "damaged.lcm";
  std::int64_t n_refused = 0;
  const long before_kb = peak_kb();
  for (int trial = 0; trial < damage.n_trials; ++trial) {
    SCOPED_TRACE(std::string(damage.name) + ", trial " + std::to_string(trial));
    Traced traced(whole_);
    damage.apply(traced, random);
    write_bytes_to(file, traced.bytes);
    const std::vector<bool> readable = readable_events(traced);
    expect_all_bytes_counted(file);
    Keeper kept;
    try {
      const LogScan scan = scan_log(file, {}, kept);
      expect_sound(kept, scan, readable);
    } catch (const InputError&) {
      ++n_refused;
      // Only a log without any run_info or any measurement is refused.
      const bool has_info = readable[0] || readable[1] || readable[2];
      EXPECT_FALSE(has_info && !readable_seq(readable, channels::measurement).empty());
    }
    if (HasFailure()) break;
  }
  // A cut before the first measurement, 1000 of 170 000 bytes, leaves nothing; the others leave a
  // run.
  EXPECT_LE(n_refused, damage.n_trials / 20);
  // The window of 4096 samples, a block of them and the file's are 3 MB; lengths that were believed
  // would show as 100 MB and more. A sanitizer keeps what was freed.
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(peak_kb() - before_kb, 32 * 1024);
#else
  EXPECT_GT(before_kb, 0);
#endif
}

INSTANTIATE_TEST_SUITE_P(Logs, KindOfDamage,
                         ::testing::Values(Damage{"cut", cut, 500, 1},  //
                                           Damage{"flip", flip, 500, 2},
                                           Damage{"flip_many", flip_many, 200, 3},
                                           Damage{"rubbish", rubbish, 200, 4},
                                           Damage{"zero", zero, 200, 5},
                                           Damage{"repeat_stretch", repeat_stretch, 200, 6},
                                           Damage{"move_stretch", move_stretch, 200, 7},
                                           Damage{"lose_stretch", lose_stretch, 200, 8},
                                           Damage{"insert_rubbish", insert_rubbish, 100, 9},
                                           Damage{"zero_tail", zero_tail, 100, 10},
                                           Damage{"false_headers", insert_false_headers, 100, 11}),
                         [](const auto& kind) { return std::string(kind.param.name); });

class ShortLogDamage : public LogDamageTest {
 protected:
  ShortLogDamage() : LogDamageTest(60) {}
};

/// Every bit of a sample, not only random ones: marks, numbers, times, lengths, names, and all
/// that is in the messages. One event at most is lost by it.
TEST_F(ShortLogDamage, NoSingleBitCostsMoreThanItsEvent) {
  std::size_t first = 0;
  while (events_[first].channel != channels::measurement) ++first;
  const std::filesystem::path file = folder_ / "damaged.lcm";
  for (std::size_t bit = 8 * events_[first + 2].begin; bit < 8 * events_[first + 3].end; ++bit) {
    SCOPED_TRACE("bit " + std::to_string(bit));
    Traced traced(whole_);
    traced.set(bit / 8, static_cast<char>(whole_[bit / 8] ^ (1 << bit % 8)));
    write_bytes_to(file, traced.bytes);
    const auto readable = readable_events(traced);
    ASSERT_EQ(std::count(readable.begin(), readable.end(), false), 1);
    Keeper kept;
    const LogScan scan = scan_log(file, {}, kept);
    expect_sound(kept, scan, readable);
    EXPECT_GE(scan.measurements.n_received + scan.commands.n_received, 2 * n_samples_ - 1);
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace stillframe::report

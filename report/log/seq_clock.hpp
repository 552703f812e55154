#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

namespace stillframe::report {

/// Whether sequence number and time of a message belong together, time_ns f_s = seq up to a slow
/// drift of the sender's clock. A damaged seq would put a sample in the place of another, or end
/// the run for all that come behind it; this is the only check that the messages allow.
class SeqClock {
 public:
  explicit SeqClock(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {}

  bool agrees(std::int64_t seq, std::int64_t time_ns) const {
    // A wrong seq is off by a whole sample at least; a clock that drifts by 1e-3 is none.
    const double distance = std::abs(static_cast<double>(seq) - last_seq_);
    return seq >= 0 && std::abs(offset(seq, time_ns) - last_offset_) <= 0.5 + 1e-3 * distance;
  }
  void follow(std::int64_t seq, std::int64_t time_ns) {
    last_offset_ = offset(seq, time_ns);
    last_seq_ = static_cast<double>(seq);
  }

 private:
  double offset(std::int64_t seq, std::int64_t time_ns) const {
    return 1e-9 * static_cast<double>(time_ns) * sample_rate_hz_ - static_cast<double>(seq);
  }

  double sample_rate_hz_, last_offset_ = 0, last_seq_ = 0;
};

/// Lets through the messages whose seq and time agree with those before. Others wait: when so many
/// in succession agree with each other that it must be the sender that has set its clock, they are
/// let through, else they are turned away.
template <typename Message>
class Admission {
 public:
  explicit Admission(double sample_rate_hz) : clock_(sample_rate_hz), waiting_clock_(clock_) {}

  template <typename Take, typename TurnAway>
  void add(Message&& message, Take&& take, TurnAway&& turn_away) {
    if (clock_.agrees(message.seq, message.time_ns)) {
      clock_.follow(message.seq, message.time_ns);
      has_taken_ = true;
      drop_waiting(turn_away);
      take(std::move(message));
      return;
    }
    if (!waiting_.empty() && !waiting_clock_.agrees(message.seq, message.time_ns)) {
      drop_waiting(turn_away);
    }
    waiting_clock_.follow(message.seq, message.time_ns);
    waiting_.push_back(std::move(message));
    if (waiting_.size() == enough) take_waiting(take);
  }

  template <typename Take, typename TurnAway>
  void finish(Take&& take, TurnAway&& turn_away) {
    if (has_taken_) return drop_waiting(turn_away);
    take_waiting(take);
  }

 private:
  static constexpr std::size_t enough = 16;

  template <typename Take>
  void take_waiting(Take&& take) {
    clock_ = waiting_clock_;
    has_taken_ = true;
    for (Message& message : waiting_) take(std::move(message));
    waiting_.clear();
  }
  template <typename TurnAway>
  void drop_waiting(TurnAway&& turn_away) {
    for (Message& message : waiting_) turn_away(message);
    waiting_.clear();
  }

  SeqClock clock_, waiting_clock_;
  std::vector<Message> waiting_;
  bool has_taken_ = false;
};

}  // namespace stillframe::report

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "msgs/clock.hpp"
#include "stillframe_msgs/clock_exchange_t.hpp"

namespace stillframe {

/// What was sent longer ago is a recording, or has waited where nobody should act on it any more.
/// Four times what a plant takes to say again that it is there, twenty times what a status takes.
inline constexpr std::int64_t fresh_ns = 2 * ns_per_s;

/// How the clocks of other processes stand to the own CLOCK_MONOTONIC. Whose instance names the own
/// clock reads the same one. Of another the offset is found by asking (SF_CLOCK):
///   offset = ((heard - asked) + (answered - back)) / 2, theirs less the own,
///   known within rtt / 2 + 500e-6 of the time since, rtt = (back - asked) - (answered - heard),
/// which holds however unequal the two ways are. The narrower of two exchanges stands; where they
/// exclude each other, a clock has stopped or stepped, and the later one does. A recording answers
/// no question, so nothing that it says is ever read. There are 16 places: who is heard and answers
/// keeps his, and who comes to a full house is not known until one is silent for fresh_ns. For one
/// thread; noexcept, no allocation.
class PeerClocks {
 public:
  explicit PeerClocks(std::int64_t own_instance) noexcept : own_(own_instance) {}

  /// Whether a clock can show this: not negative, and so that sums fit an int64 (73 years).
  static bool is_reading(std::int64_t ns) noexcept {
    return ns >= 0 && ns < (std::int64_t{1} << 61);
  }

  /// Between which instants of the own clock a peer's reading fell.
  struct Instant {
    std::int64_t earliest_ns = 0, latest_ns = 0;
  };

  /// None while the peer's clock is not known; it is asked for then.
  std::optional<Instant> instant(std::int64_t peer, std::int64_t reading_ns,
                                 std::int64_t now_ns) noexcept;
  /// Whether what a peer says it sent at sent_ns was certainly sent just now.
  bool is_fresh(std::int64_t peer, std::int64_t sent_ns, std::int64_t now_ns) noexcept;

  /// What a peer says cannot be: its clock may have stood still, and is asked for again.
  void doubt(std::int64_t peer) noexcept;

  /// The next question that is due; to be published at once.
  std::optional<stillframe_msgs::clock_exchange_t> question(std::int64_t now_ns) noexcept;
  /// Takes what came on SF_CLOCK; the answer, if it was a question to this process, to be published
  /// at once.
  std::optional<stillframe_msgs::clock_exchange_t> take(
      const stillframe_msgs::clock_exchange_t& message, std::int64_t now_ns) noexcept;

  /// In words, to be put behind "nobody answered": that somebody was heard who did not say what its
  /// clock reads, or found no place. Empty if nobody was. Set-up.
  std::string unanswered() const;

 private:
  struct Peer {
    std::int64_t instance = 0;
    std::int64_t used_ns = 0;
    bool wanted = false;
    std::int64_t asked_ns = 0;  ///< of the question that is open, or was the last
    bool open = false;
    bool known = false;
    std::int64_t offset_ns = 0, half_ns = 0, known_ns = 0;
    std::int64_t heard_ns = 0;  ///< when the last answer came
    bool doubted = false;
    std::int64_t doubt_ns(std::int64_t now_ns) const noexcept;
    bool stays(std::int64_t now_ns) const noexcept;  ///< whatever others come
  };
  Peer* of(std::int64_t instance, std::int64_t now_ns) noexcept;
  void learn(Peer& peer, const stillframe_msgs::clock_exchange_t& answer,
             std::int64_t now_ns) noexcept;

  std::int64_t own_;
  std::array<Peer, 16> peers_{};
  bool full_ = false;  ///< somebody found no place
};

}  // namespace stillframe

#include "msgs/peer_clocks.hpp"

#include <algorithm>
#include <utility>

#include "msgs/identity.hpp"

namespace stillframe {

using stillframe_msgs::clock_exchange_t;

namespace {

// Of a question without an answer: longer than any way there and back, and a second of it is what a
// user who starts the second of two programs waits for.
constexpr std::int64_t ask_again_ns = ns_per_s / 2;
// At 500 ppm 2.5 ms.
constexpr std::int64_t renew_ns = 5 * ns_per_s;
// Of one that is asked every 5 s, and twice a second while it does not answer.
constexpr std::int64_t answers_ns = 2 * renew_ns;
// An answer that leaves more than this in doubt is one of a process that was late to look.
constexpr std::int64_t wide_ns = ns_per_s / 20;
constexpr std::int64_t drift_part = 2000;  // 500 ppm, of two crystals against each other

}  // namespace

std::int64_t PeerClocks::Peer::doubt_ns(std::int64_t now_ns) const noexcept {
  return half_ns + (now_ns - known_ns) / drift_part;
}

bool PeerClocks::Peer::stays(std::int64_t now_ns) const noexcept {
  return known && now_ns - used_ns < fresh_ns && now_ns - heard_ns < answers_ns;
}

PeerClocks::Peer* PeerClocks::of(std::int64_t instance, std::int64_t now_ns) noexcept {
  auto peer = std::ranges::find(peers_, instance, &Peer::instance);
  if (peer == peers_.end()) {
    // Of more than there are places, each would push the next one out before it is heard again.
    const auto key = [now_ns](const Peer& p) { return std::pair(p.stays(now_ns), p.used_ns); };
    peer = std::ranges::min_element(peers_, {}, key);
    if (peer->stays(now_ns)) {
      full_ = true;
      return nullptr;
    }
    *peer = {.instance = instance};
  }
  peer->used_ns = now_ns;
  return &*peer;
}

std::optional<PeerClocks::Instant> PeerClocks::instant(std::int64_t peer, std::int64_t reading_ns,
                                                       std::int64_t now_ns) noexcept {
  if (on_one_clock(peer, own_)) return Instant{reading_ns, reading_ns};
  Peer* const there = of(peer, now_ns);
  if (there == nullptr) return std::nullopt;
  there->wanted = true;
  // Beyond that nothing could be told from a recording.
  if (!there->known || there->doubt_ns(now_ns) > fresh_ns / 2 || !is_reading(reading_ns)) {
    return std::nullopt;
  }
  const std::int64_t here = reading_ns - there->offset_ns, doubt = there->doubt_ns(now_ns);
  return Instant{here - doubt, here + doubt};
}

bool PeerClocks::is_fresh(std::int64_t peer, std::int64_t sent_ns, std::int64_t now_ns) noexcept {
  const auto sent = instant(peer, sent_ns, now_ns);
  if (!sent) return false;
  const bool fresh = sent->earliest_ns <= now_ns && sent->earliest_ns > now_ns - fresh_ns;
  if (!fresh) doubt(peer);
  return fresh;
}

void PeerClocks::doubt(std::int64_t peer) noexcept {
  const auto there = std::ranges::find(peers_, peer, &Peer::instance);
  if (there != peers_.end() && !on_one_clock(peer, own_)) there->doubted = true;
}

std::optional<clock_exchange_t> PeerClocks::question(std::int64_t now_ns) noexcept {
  for (Peer& peer : peers_) {
    if (!peer.wanted) continue;
    const bool due = peer.asked_ns == 0 || now_ns - peer.asked_ns > ask_again_ns;
    const bool good = peer.known && peer.half_ns < wide_ns && !peer.doubted;
    if (!due || (good && now_ns - peer.heard_ns < renew_ns)) continue;
    peer.wanted = false;
    peer.open = true;
    peer.asked_ns = now_ns;
    return clock_exchange_t{
        .asker = own_, .asked = peer.instance, .asked_ns = now_ns, .heard_ns = 0, .answered_ns = 0};
  }
  return std::nullopt;
}

std::optional<clock_exchange_t> PeerClocks::take(const clock_exchange_t& message,
                                                 std::int64_t now_ns) noexcept {
  const bool is_question = message.heard_ns == 0 && message.answered_ns == 0;
  if (is_question) {
    if (message.asked != own_ || message.asker == own_) return std::nullopt;
    clock_exchange_t answer = message;
    answer.heard_ns = answer.answered_ns = now_ns;
    return answer;
  }
  if (message.asker != own_) return std::nullopt;
  const auto peer = std::ranges::find(peers_, message.asked, &Peer::instance);
  if (peer == peers_.end() || !peer->open || message.asked_ns != peer->asked_ns) {
    return std::nullopt;
  }
  peer->open = false;
  learn(*peer, message, now_ns);
  return std::nullopt;
}

std::string PeerClocks::unanswered() const {
  if (full_) {
    return "; more than " + std::to_string(peers_.size()) +
           " processes on other clocks are heard, and no more are asked what theirs read";
  }
  const auto silent = [](const Peer& peer) { return peer.asked_ns != 0 && !peer.known; };
  if (!std::ranges::any_of(peers_, silent)) return "";
  return "; somebody on another clock was heard, who did not say on SF_CLOCK what that reads: a "
         "recording, a program of another version, or a network that lets one way through alone";
}

void PeerClocks::learn(Peer& peer, const clock_exchange_t& answer, std::int64_t now_ns) noexcept {
  if (!is_reading(answer.heard_ns) || !is_reading(answer.answered_ns)) return;
  const std::int64_t whole = now_ns - answer.asked_ns, there = answer.answered_ns - answer.heard_ns;
  if (there < 0 || there > whole || whole > fresh_ns) return;
  const std::int64_t half = (whole - there + 1) / 2;
  const std::int64_t offset =
      answer.heard_ns - answer.asked_ns +
      (answer.answered_ns - now_ns - (answer.heard_ns - answer.asked_ns)) / 2;
  const std::int64_t doubt = peer.known ? peer.doubt_ns(now_ns) : 0;
  const bool excluded = peer.known && std::abs(offset - peer.offset_ns) > doubt + half;
  peer.heard_ns = now_ns;
  peer.doubted = false;
  if (peer.known && !excluded && half > doubt) return;
  peer.known = true;
  peer.offset_ns = offset;
  peer.half_ns = half;
  peer.known_ns = now_ns;
}

}  // namespace stillframe

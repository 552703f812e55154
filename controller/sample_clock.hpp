#pragma once

#include <cstdint>
#include <optional>

#include "controller/io.hpp"

namespace stillframe::controller {

/// Whose clock paces the samples.
enum class Pacing {
  same_clock,  ///< this host's: sample k is taken at start_ns + k T
  other_host,  ///< that of a plant on another host, whose numbers are the samples'
  card         ///< a crystal of the converters, whose numbers may step and begin anew
};

/// Which instant of CLOCK_MONOTONIC a sample belongs to. Of a plant on the same clock it is
/// start_ns + time_ns. Of all others, where the clock is disciplined, only the arrivals are seen:
/// sample k was taken at l_k = l_r + (k - r) T (1 + d), with the earliest arrivals as reference
/// l_r, since a sample may come late but not early. What all of them take on their way counts as
/// none.
///   e = arrival - l_k:   e < 0: l_r += e;   0 < e < T / 2: l_r += min(e, 500e-6 T per sample);
///   d: the slope of l_r over the last 10 s or more.
/// The first sample of a card is number 0; it may have come as late as it likes. Where |e| is T / 2
/// or more for `settle` samples in a row that come one after the other (behind a stall they come at
/// once, or catch up: the earliest of the second half is late by less than that of the first), the
/// card has stepped, paused or begun anew: by the earliest of them its samples are
/// numbered from there on as the time says, so that numbers go on rising and a pause counts as
/// samples lost. What a plant on another host calls its samples stays, and the line moves.
/// Arrivals alone do not tell a clock that stood still from a way that takes longer; what the
/// clocks say does (bound): sample k was taken at b + k T with b in [b_0, b_1]. The line moves
///   later only if l_k < b_0 + k T, which no way explains, and to b_1 + k T + T / 2 at most;
///   earlier only to b_0 + k T at least, as what comes before it was taken is not of now.
/// Else the samples are late, for as long as their way is long, and the line runs on by its last
/// slope. Below T / 2 the line goes along, as with any drift.
/// Construction is set-up; the rest is hot.
class SampleClock {
 public:
  static constexpr int settle = 20;             ///< samples
  static constexpr double most_drift = 500e-6;  ///< 1, of a crystal

  /// sample_rate_hz as the card is set to. Errors: std::invalid_argument if it is not positive.
  /// start_doubt_ns: of a plant on another host, how far start_ns may be off: a first sample that
  /// is off by more than that and 0.1 s, or 20 periods, is a recording's or forged, and not
  /// followed.
  SampleClock(std::int64_t start_ns, double sample_rate_hz, Pacing pacing,
              std::int64_t start_doubt_ns = 0);

  /// Takes an arrival, in the order of the card, and gives it its number and its time from the
  /// start of the run; does nothing if the clock is not disciplined.
  void see(Measurement& measurement) noexcept;

  /// Of a plant on another host: between which instants of CLOCK_MONOTONIC its run began, as the
  /// clocks stand to each other now (PeerClocks). Before the first, and after unbound, the line
  /// follows the arrivals alone.
  void bound(std::int64_t earliest_ns, std::int64_t latest_ns) noexcept;
  void unbound() noexcept { bounded_ = false; }

  /// CLOCK_MONOTONIC, ns, of what was taken time_ns after the start of the run.
  std::int64_t local_ns(std::int64_t time_ns) const noexcept;
  /// s from the sample to now_ns.
  double age(const Measurement& measurement, std::int64_t now_ns) const noexcept {
    return static_cast<double>(now_ns - local_ns(measurement.time_ns)) * 1e-9;
  }

  bool disciplined() const noexcept { return pacing_ != Pacing::same_clock; }
  bool keeps_numbers() const noexcept { return pacing_ == Pacing::other_host; }
  bool locked() const noexcept { return locked_; }  ///< a first sample has come
  /// The line of samples: l_r (ns), r and T (1 + d) (ns).
  std::int64_t reference_ns() const noexcept { return reference_ns_; }
  std::int64_t reference() const noexcept { return reference_; }
  double period_ns() const noexcept { return period_ns_; }
  double drift() const noexcept { return period_ns_ / nominal_ns_ - 1; }  ///< d, 1
  std::int64_t n_locks() const noexcept { return n_locks_; }  ///< beside the first: steps, restarts
  /// How often the line would have moved but for the clocks.
  std::int64_t n_held() const noexcept { return n_held_; }

 private:
  double error_ns(std::int64_t seq, std::int64_t received_ns) const noexcept;
  void track(std::int64_t seq, double error) noexcept;
  std::optional<double> admitted(std::int64_t seq, double by) const noexcept;
  void lock(std::int64_t card, std::int64_t taken_ns) noexcept;
  void begin_slope() noexcept;

  double nominal_ns_, period_ns_;
  Pacing pacing_;
  bool locked_ = false;
  std::int64_t start_ns_;
  std::int64_t reference_ns_, reference_ = 0;  ///< l_r, r
  double part_ns_ = 0;                         ///< of l_r, below a ns
  std::int64_t epoch_ = 0;                     ///< number of a sample less that of the card
  std::int64_t last_ = -1;                     ///< newest number on the line
  std::int64_t first_ = 0;                     ///< of the numbers that go on since a lock
  std::int64_t slope_ns_ = 0, slope_from_ = 0;
  double slope_part_ns_ = 0;
  std::int64_t in_row_ = 0;  ///< samples on the line since a gap or lock
  bool new_line_ = true;     ///< whose slope has not begun
  int n_off_ = 0;            ///< samples in a row that are off the line
  double least_off_ = 0,
         least_off_before_ = 0;  ///< e of the earliest of a half, and of the one before
  double most_shown_ns_;         ///< by which a first sample may be off its place
  std::int64_t off_since_ns_ = 0;
  std::int64_t before_ = 0;  ///< number of the last of them, as the card has it
  std::int64_t n_locks_ = 0, n_held_ = 0;
  bool bounded_ = false;
  std::int64_t earliest_ns_ = 0, latest_ns_ = 0;  ///< b_0, b_1
};

}  // namespace stillframe::controller

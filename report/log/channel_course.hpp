#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/numerics/infinity.hpp"

namespace stillframe::report {

/// How much a channel moved, from sample to sample.
struct Variation {
  double sum = 0;      ///< of the sizes of its changes, in its unit
  std::int64_t n = 0;  ///< changes
};

/// Consecutive samples in which a channel is the same to the bit.
struct Rest {
  /// Fewer samples may rest by chance, and commands take up to 20 to act.
  static constexpr std::int64_t fewest = 50, settled = 20;

  std::int64_t first_seq = 0, last_seq = 0;
  std::int64_t n = 0;  ///< samples; 0: there is none of at least `fewest`
  double value = 0;
  std::vector<Variation> during;  ///< of every channel, from sample `settled` on
};

/// What one channel did over a run.
struct ChannelCourse {
  double first = 0, lowest = 0, highest = 0;
  std::int64_t n = 0, n_other = 0;  ///< samples, and those that differ from the first
  std::int64_t n_since = 0;         ///< samples from the first of those on
  Variation moved = {};
  double smallest_change = infinity;
  Rest rest = {};  ///< the one in which most was done by what is followed beside

  bool rests() const { return n_other == 0; }
};

/// Whether a rest is odd for a channel that moved elsewhere. inside, outside: how much was done
/// there of what moves it, in any unit. Neither what a coarse converter shows of a quiet part nor
/// the turning points of slow motion are odd.
bool is_odd(const ChannelCourse& course, double inside, double outside);

/// Follows channels, sample by sample.
class CourseRecorder {
 public:
  /// The channels by which the rests of one are chosen.
  struct Beside {
    std::size_t first = 0, end = 0;
  };

  /// One of each channel; without channels beside it the rests of one are not followed.
  explicit CourseRecorder(std::vector<Beside> beside);

  /// Takes the next values of the channels from `first` on, n of them.
  void take(std::int64_t seq, const double* values, std::size_t first, std::size_t n);
  /// With the rests that last to the end.
  std::vector<ChannelCourse> courses() const;

 private:
  struct Now {
    double value = 0;
    std::int64_t first_seq = 0, last_seq = 0, n = 0;  ///< of the rest that it is in
    std::vector<Variation> before = {};               ///< what had moved when that had settled
  };

  void close(std::size_t i, ChannelCourse& course) const;

  std::vector<Beside> beside_;
  std::vector<ChannelCourse> courses_;
  std::vector<Variation> moved_;
  std::vector<Now> now_;
};

}  // namespace stillframe::report

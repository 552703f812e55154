#pragma once

#include <cstdint>
#include <vector>

#include "stillframe_msgs/measurement_t.hpp"
#include "tests/faults/fault_model.hpp"

namespace stillframe::faults {

/// What is wrong with measurements.
enum class Corruption {
  none,
  not_finite,    ///< sigma of one leg is not a number
  out_of_range,  ///< sigma of one leg is 1e9 N
  wrong_size,    ///< one leg too many
  truncated,     ///< the last bytes are missing
  frozen,        ///< sigma of one leg stays what it was
  other_run,     ///< beside each measurement comes one of another run, with forces of 1e4 N
  later,         ///< beside each comes one as of 5000 samples later, with forces of 1e4 N
  replayed,      ///< beside each measurement comes the one of 1000 samples ago
};

/// Damages measurements on their way from the plant. Seeded by the leg that it damages.
class Corruptor {
 public:
  static constexpr std::size_t replay_age = 1000;  ///< samples

  /// From now on this is wrong, with this leg.
  void begin(Corruption corruption, std::int32_t leg);
  void end() { corruption_ = Corruption::none; }

  /// Takes every measurement in turn; gives what goes on to the wire, one message or more.
  std::vector<Bytes> apply(const Bytes& bytes, const stillframe_msgs::measurement_t& measurement);

  std::int64_t n_corrupted() const { return n_corrupted_; }

 private:
  std::vector<Bytes> damage(const Bytes& bytes, stillframe_msgs::measurement_t measurement);

  Corruption corruption_ = Corruption::none;
  std::int32_t leg_ = 0;
  double frozen_sigma_ = 0;
  bool has_frozen_ = false;
  std::deque<Bytes> past_;
  std::int64_t n_corrupted_ = 0;
};

/// The bytes of a message.
template <class Message>
Bytes encoded(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace stillframe::faults

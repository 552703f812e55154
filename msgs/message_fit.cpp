#include "msgs/message_fit.hpp"

#include "msgs/big_endian.hpp"
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

namespace stillframe {

using namespace stillframe_msgs;

namespace {

/// Goes through a payload field by field; once a field does not fit, nothing does.
class Walk {
 public:
  explicit Walk(std::string_view bytes) : rest_(bytes) {}

  void numbers(std::size_t n, std::size_t bytes) {
    if (!fits_ || n > rest_.size() / bytes) return fail();
    rest_.remove_prefix(n * bytes);
  }
  void int64s(std::size_t n) { numbers(n, 8); }
  void doubles(std::size_t n) { numbers(n, 8); }
  void int32s(std::size_t n) { numbers(n, 4); }
  void booleans(std::size_t n) { numbers(n, 1); }

  /// The length of a list. An entry takes at least a byte, so no longer one can fit.
  std::size_t count() {
    const std::string_view here = rest_;
    int32s(1);
    if (!fits_) return 0;
    const std::int32_t n = read_int32(here.data());
    if (n >= 0 && static_cast<std::size_t>(n) <= rest_.size()) return static_cast<std::size_t>(n);
    fail();
    return 0;
  }

  /// A length that counts the closing zero, then the letters and that zero.
  void texts(std::size_t n) {
    for (std::size_t i = 0; i < n && fits_; ++i) {
      const std::size_t length = count();
      if (!fits_ || length == 0 || rest_[length - 1] != '\0') return fail();
      rest_.remove_prefix(length);
    }
  }

  bool fits() const { return fits_; }
  bool is_at_end() const { return fits_ && rest_.empty(); }

 private:
  void fail() { fits_ = false; }

  std::string_view rest_;
  bool fits_ = true;
};

// The fields of each type in the order of its .lcm file; a change there changes the fingerprint,
// and the tests compare these with what lcm-gen writes.

void walk(Walk& w, const measurement_t*) {
  w.int64s(5);
  const std::size_t n_floor = w.count(), n_legs = w.count(), n_frame = w.count();
  w.doubles(n_floor), w.doubles(n_legs), w.doubles(n_legs), w.doubles(n_frame);
}

void walk(Walk& w, const command_t*) {
  w.int64s(6);
  w.doubles(w.count());
  w.booleans(1);
}

void walk(Walk& w, const run_info_t*) {
  w.int64s(2), w.int32s(1);
  w.texts(8);
  w.doubles(2), w.int64s(1);
  const std::size_t n_floor = w.count(), n_legs = w.count(), n_frame = w.count();
  w.texts(n_floor), w.texts(n_legs), w.texts(n_frame);
}

void walk(Walk& w, const run_state_t*) {
  w.int64s(4), w.texts(1), w.int32s(1), w.int64s(1), w.texts(1);
}

void walk(Walk& w, const timing_t*) { w.int64s(1), w.texts(1), w.int64s(9); }

void walk(Walk& w, const control_request_t*) { w.int64s(4), w.int32s(1); }

void walk(Walk& w, const controller_status_t*) {
  w.int64s(5), w.int32s(3), w.booleans(1), w.texts(1);
  w.int64s(1), w.texts(1), w.int64s(14);
}

void walk(Walk& w, const loop_records_t*) {
  w.int64s(2);
  const std::size_t n = w.count();
  for (std::size_t i = 0; i < n && w.fits(); ++i) {
    w.int64s(7), w.int32s(4), w.booleans(3), w.int64s(2);
    const std::size_t n_legs = w.count();
    w.doubles(n_legs), w.doubles(n_legs), w.doubles(n_legs);
    w.doubles(w.count());
  }
}

void walk(Walk& w, const loop_checkpoint_t*) {
  w.int64s(3), w.texts(1);
  w.doubles(w.count());
}

void walk(Walk& w, const excitation_t*) {
  w.int64s(3);
  w.doubles(w.count());
}

void walk(Walk& w, const clock_exchange_t*) { w.int64s(5); }

constexpr std::size_t fingerprint_size = 8;

}  // namespace

template <typename Message>
Fit fit(std::string_view payload) noexcept {
  if (payload.size() < fingerprint_size) return Fit::damaged;
  const std::int64_t fingerprint = read_int64(payload.data());
  // A stretch of zeros is what a broken disk leaves, and no fingerprint.
  if (fingerprint == 0) return Fit::damaged;
  if (fingerprint != Message::getHash()) return Fit::other_version;
  Walk w(payload.substr(fingerprint_size));
  walk(w, static_cast<const Message*>(nullptr));
  return w.is_at_end() ? Fit::whole : Fit::damaged;
}

template Fit fit<measurement_t>(std::string_view) noexcept;
template Fit fit<command_t>(std::string_view) noexcept;
template Fit fit<run_info_t>(std::string_view) noexcept;
template Fit fit<run_state_t>(std::string_view) noexcept;
template Fit fit<timing_t>(std::string_view) noexcept;
template Fit fit<control_request_t>(std::string_view) noexcept;
template Fit fit<controller_status_t>(std::string_view) noexcept;
template Fit fit<loop_records_t>(std::string_view) noexcept;
template Fit fit<loop_checkpoint_t>(std::string_view) noexcept;
template Fit fit<excitation_t>(std::string_view) noexcept;
template Fit fit<clock_exchange_t>(std::string_view) noexcept;

}  // namespace stillframe

#pragma once

#include <atomic>
#include <cstdint>

#include "controller/supervisor.hpp"

namespace stillframe::controller {

/// Where a request waits for the next period of a loop. There is one place, and a stop takes it
/// whatever waits there. Hot: noexcept, no allocation, no lock.
class RequestSlot {
 public:
  struct Asked {
    Request request = Request::none;
    std::int64_t number = 0;
  };

  /// Answers the number of the request, which rises; 0 if it is no stop and the place is taken. Any
  /// thread.
  std::int64_t ask(Request request) noexcept {
    const std::int64_t number = ++n_asked_;
    const std::int64_t asked = number * kinds + static_cast<std::int64_t>(request);
    std::int64_t none = 0;
    if (request == Request::stop) {
      waiting_.store(asked);
    } else if (!waiting_.compare_exchange_strong(none, asked)) {
      return 0;
    }
    return number;
  }

  /// The loop's: takes what waits, and says when its effect can be seen.
  Asked take() noexcept {
    const std::int64_t asked = waiting_.exchange(0);
    return {static_cast<Request>(asked % kinds), asked / kinds};
  }
  void done(const Asked& asked) noexcept {
    if (asked.number > 0) done_.store(asked.number, std::memory_order_release);
  }

  /// True once the request of this number, or a later one in its place, was obeyed. Any thread.
  bool is_done(std::int64_t number) const noexcept {
    return done_.load(std::memory_order_acquire) >= number;
  }

 private:
  static constexpr std::int64_t kinds = 4;  // of requests, none included
  std::atomic<std::int64_t> n_asked_{0}, done_{0};
  std::atomic<std::int64_t> waiting_{0};  ///< number * kinds + request; 0: none
};

}  // namespace stillframe::controller

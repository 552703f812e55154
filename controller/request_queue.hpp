#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "controller/request_slot.hpp"

namespace stillframe::controller {

/// What was asked of the controller, and what came of it.
struct LastRequest {
  std::int64_t nonce = 0;
  std::string answer;  ///< empty: done
};

/// Requests on their way from the bus to the loop, one after the other: a reset must have been
/// obeyed before a start can be judged. A stop goes before all that waits, and ends every start
/// that came before it. Every request that is heard gets one answer, also where there is no room
/// for it; the last 256 are kept until they are told. Bounded. Set-up.
class RequestQueue {
 public:
  /// Why a request is refused; empty if it is not.
  using Refusal = std::function<std::string(Request)>;

  /// A request that was not heard before (class Requests sees to that).
  void hear(Request request, std::int64_t nonce);
  /// Gives the loop what can be given now.
  void serve(RequestSlot& slot, const Refusal& refusal);
  /// The next answer that was not told yet.
  std::optional<LastRequest> answer();

 private:
  struct Asked {
    Request request;
    std::int64_t nonce;
    std::int64_t number;  ///< with the loop; 0: not yet
  };
  void settle(const Asked& asked, const std::string& answer);

  std::deque<Asked> waiting_;  ///< oldest first
  std::deque<LastRequest> answers_;
};

}  // namespace stillframe::controller

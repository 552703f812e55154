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
/// that came before it. Whoever asks repeats a request until the status names it; it is obeyed
/// once. Bounded. Set-up.
class RequestQueue {
 public:
  /// Why a request is refused; empty if it is not.
  using Refusal = std::function<std::string(Request)>;

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
  bool is_known(std::int64_t nonce) const;
  void settle(const Asked& asked, const std::string& answer);

  std::deque<Asked> waiting_;  ///< oldest first
  std::deque<LastRequest> answers_;
  std::deque<std::int64_t> settled_;  ///< nonces
};

}  // namespace stillframe::controller

#pragma once

#include <semaphore.h>

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <thread>

#include "controller/io.hpp"
#include "controller/measurement_decoder.hpp"
#include "controller/policy.hpp"
#include "controller/ring.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::controller {

/// Io over LCM. A receiving and a sending thread stand between the loop and the sockets, each with
/// an LCM of its own, so that the loop shares no lock with anybody and whatever a socket does
/// delays no period. Construction and destruction are set-up, receive and send hot.
/// Source: docs/decisions/0013-loop-and-threads.md.
class LcmStream : public Io {
 public:
  /// Follows a run, and signs commands as this instance. The threads ask for real time as the
  /// policy says, one priority below the loop. Errors: InputError if LCM cannot be opened.
  LcmStream(const std::string& url, const stillframe_msgs::run_info_t& info, std::int64_t instance,
            const Policy& policy);
  ~LcmStream() override;
  LcmStream(const LcmStream&) = delete;
  LcmStream& operator=(const LcmStream&) = delete;

  bool receive(Measurement& measurement) noexcept override;
  void send(const Command& command) noexcept override;

  /// Bad are measurements of another run, size or type, and those that found no room; another
  /// controller is obeyed as every measurement says so.
  IoState state() const noexcept override {
    return {.n_bad = n_bad_,
            .n_dropped = n_commands_dropped_,
            .obeys_another_since_ns = obeys_another_since_ns_};
  }

 private:
  void end_threads();
  void run_receiver(const Policy& policy) noexcept;
  void run_sender(const Policy& policy) noexcept;
  void on_measurement(const lcm::ReceiveBuffer* buffer, const std::string& channel) noexcept;

  void note_obeyed(std::int64_t controller, std::int64_t now_ns) noexcept;

  std::unique_ptr<lcm::LCM> in_, out_;
  MeasurementDecoder decoder_;
  Ring<Measurement> measurements_;
  Ring<Command> commands_;
  stillframe_msgs::command_t message_;
  std::vector<std::uint8_t> bytes_;
  std::atomic<std::int64_t> obeys_another_since_ns_{0};
  std::atomic<std::int64_t> n_bad_{0}, n_commands_dropped_{0};
  sem_t something_to_send_{};
  std::atomic<bool> stop_{false}, listening_{false}, deaf_{false};
  std::thread receiver_, sender_;
};

}  // namespace stillframe::controller

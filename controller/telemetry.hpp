#pragma once

#include <string>
#include <vector>

#include "controller/controller_link.hpp"
#include "controller/io.hpp"
#include "controller/loop.hpp"
#include "controller/presence.hpp"
#include "controller/request_queue.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_record_t.hpp"

namespace stillframe::controller {

/// The messages of records and checkpoints. Set-up.
stillframe_msgs::loop_record_t to_message(const LoopRecord& record);
stillframe_msgs::loop_checkpoint_t to_message(const LoopCheckpoint& checkpoint, std::int64_t run_id,
                                              std::int64_t instance,
                                              const std::string& policy_text);
/// The way back, for replay; the vectors get their sizes from the message.
LoopRecord from_message(const stillframe_msgs::loop_record_t& message);

/// The last fault, with the leg that began it where one did: "restless, leg_2 first". Set-up.
std::string fault_in_words(const LoopCounters& counters, const std::vector<std::string>& leg_names);
/// The same of a leg by its name; empty: of none.
std::string fault_in_words(Fault fault, const std::string& leg);
/// The name of the leg that began it, empty where none did.
std::string leg_of_fault(const LoopCounters& counters, const std::vector<std::string>& leg_names);

/// What a status adds where the feed-forward does not act, and why; else nothing.
std::string floor_in_words(const LoopCounters& counters,
                           const std::vector<std::string>& floor_names);

/// Tells the bus what the loop does, from a thread that may be slow. Set-up.
class Telemetry {
 public:
  /// All outlive the telemetry. policy_text: of the policy file, for replay.
  Telemetry(ControllerLink& link, Loop& loop, const Io& io, const Presence& presence,
            const std::string& policy_text);

  /// Publishes the records and checkpoints that wait, in their order; of a rig, which has no other
  /// voice, also what was measured and commanded.
  void publish_records();
  void publish_status(const LastRequest& request);

 private:
  ControllerLink& link_;
  Loop& loop_;
  const Io& io_;
  const Presence& presence_;
  const std::string& policy_text_;
};

}  // namespace stillframe::controller

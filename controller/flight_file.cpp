#include "controller/flight_file.hpp"

#include "controller/telemetry.hpp"
#include "core/files/whole_file.hpp"
#include "msgs/channels.hpp"
#include "msgs/log_writer.hpp"
#include "stillframe_msgs/loop_records_t.hpp"

namespace stillframe::controller {

void write_flight_file(const std::filesystem::path& file, const stillframe_msgs::run_info_t& info,
                       const FlightRecorder& recorder, const std::string& policy_text) {
  constexpr std::int64_t ns_per_us = 1000;
  const auto records = recorder.records();
  const auto checkpoints = recorder.checkpoints();
  WholeFile whole(file);
  LogWriter log(whole.present());
  bool sound = true;
  const auto write = [&](const char* channel, std::int64_t time_ns, const auto& message) {
    sound = log.write(channel, message, time_ns / ns_per_us) && sound;
  };
  write(channels::run_info, records.empty() ? 0 : records.front()->wake_up_ns, info);
  auto checkpoint = checkpoints.begin();
  for (const LoopRecord* record : records) {
    for (; checkpoint != checkpoints.end() && (*checkpoint)->period <= record->period;
         ++checkpoint) {
      if ((*checkpoint)->period < records.front()->period) continue;
      write(channels::checkpoint, record->wake_up_ns,
            to_message(**checkpoint, info.run_id, 0, policy_text));
    }
    stillframe_msgs::loop_records_t message;
    message.run_id = info.run_id;
    message.instance = 0;
    message.n_records = 1;
    message.records.push_back(to_message(*record));
    write(channels::loop, record->wake_up_ns, message);
  }
  if (!(log.finish() && sound)) throw OutputError(file.string() + ": cannot be written");
  whole.save();
}

}  // namespace stillframe::controller

#include "controller/flight_file.hpp"

#include <lcm/lcm-cpp.hpp>

#include "controller/telemetry.hpp"
#include "core/yaml/input_error.hpp"
#include "msgs/channels.hpp"
#include "stillframe_msgs/loop_records_t.hpp"

namespace stillframe::controller {

namespace {

constexpr std::int64_t ns_per_us = 1000;

class LogWriter {
 public:
  explicit LogWriter(const std::filesystem::path& file) : log_(file.string(), "w") {
    if (!log_.good()) throw InputError(file.string() + ": cannot be written");
  }

  template <class Message>
  void write(const char* channel, std::int64_t time_ns, const Message& message) {
    bytes_.resize(static_cast<size_t>(message.getEncodedSize()));
    message.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
    lcm::LogEvent event{};
    event.eventnum = n_++;
    event.timestamp = time_ns / ns_per_us;
    event.channel = channel;
    event.datalen = static_cast<std::int32_t>(bytes_.size());
    event.data = bytes_.data();
    good_ = log_.writeEvent(&event) == 0 && good_;
  }
  bool good() const { return good_; }

 private:
  lcm::LogFile log_;
  std::vector<std::uint8_t> bytes_;
  std::int64_t n_ = 0;
  bool good_ = true;
};

}  // namespace

void write_flight_file(const std::filesystem::path& file, const stillframe_msgs::run_info_t& info,
                       const FlightRecorder& recorder, const std::string& policy_text) {
  const std::filesystem::path part = file.string() + ".part";
  const auto records = recorder.records();
  const auto checkpoints = recorder.checkpoints();
  bool good = false;
  {
    LogWriter log(part);
    log.write(channels::run_info, records.empty() ? 0 : records.front()->wake_up_ns, info);
    auto checkpoint = checkpoints.begin();
    for (const LoopRecord* record : records) {
      for (; checkpoint != checkpoints.end() && (*checkpoint)->period <= record->period;
           ++checkpoint) {
        if ((*checkpoint)->period < records.front()->period) continue;
        log.write(channels::checkpoint, record->wake_up_ns,
                  to_message(**checkpoint, info.run_id, 0, policy_text));
      }
      stillframe_msgs::loop_records_t message;
      message.run_id = info.run_id;
      message.instance = 0;
      message.n_records = 1;
      message.records.push_back(to_message(*record));
      log.write(channels::loop, record->wake_up_ns, message);
    }
    good = log.good();
  }
  std::error_code error;
  if (good) std::filesystem::rename(part, file, error);
  if (!good || error) {
    std::filesystem::remove(part, error);
    throw InputError(file.string() + ": cannot be written");
  }
}

}  // namespace stillframe::controller

#include "tests/fuzz/seeds.hpp"

#include <fstream>
#include <string>
#include <vector>

#include "tests/fuzz/message_types.hpp"
#include "tests/report/sample_log.hpp"

namespace stillframe::fuzz {

using namespace stillframe_msgs;

namespace {

/// The bytes behind the fingerprint, behind that of the type, as the target `messages` takes them.
template <typename Message>
void write_message(const std::filesystem::path& folder, const Message& message) {
  std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  std::ofstream file(folder / Message::getTypeName(), std::ios::binary);
  file.put(static_cast<char>(index_of<Message>()));
  file.write(bytes.data() + fingerprint_size,
             static_cast<std::streamsize>(bytes.size() - fingerprint_size));
}

template <typename Message>
void write_default(const std::filesystem::path& folder) {
  write_message(folder, Message{});
}

}  // namespace

void write_seeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "messages");
  std::filesystem::create_directories(folder / "log");
  write_message(folder / "messages", report::sample_info(1, 3));
  write_message(folder / "messages", report::sample_measurement(1, 2));
  write_message(folder / "messages", report::sample_command(1, 2));
  write_default<run_state_t>(folder / "messages");
  write_default<timing_t>(folder / "messages");
  write_default<control_request_t>(folder / "messages");
  write_default<controller_status_t>(folder / "messages");
  loop_records_t records{};
  records.records.resize(2);
  records.n_records = 2;
  write_message(folder / "messages", records);
  write_default<loop_checkpoint_t>(folder / "messages");
  write_default<excitation_t>(folder / "messages");
  write_default<clock_exchange_t>(folder / "messages");
  report::LogWriter log(folder / "log/run.lcm");
  report::write_run(log, 7, 3);
}

}  // namespace stillframe::fuzz

#include "msgs/log_writer.hpp"

#include <cstdio>
#include <ctime>

#include "core/errors/input_error.hpp"

namespace stillframe {

LogWriter::LogWriter(const std::filesystem::path& file) : file_(file.string(), "w") {
  if (!file_.good()) throw InputError(file.string() + ": cannot be written");
}

std::int64_t LogWriter::now_us() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * std::int64_t{1'000'000} + now.tv_nsec / 1000;
}

bool LogWriter::write_bytes(const char* channel, std::int64_t time_us) {
  event_.timestamp = time_us;
  event_.channel = channel;
  event_.datalen = static_cast<std::int32_t>(bytes_.size());
  event_.data = bytes_.data();
  return file_.writeEvent(&event_) == 0;
}

bool LogWriter::finish() { return std::fflush(file_.getFilePtr()) == 0; }

}  // namespace stillframe

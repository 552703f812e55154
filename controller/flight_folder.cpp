#include "controller/flight_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <regex>
#include <string>
#include <vector>

namespace stillframe::controller {

namespace fs = std::filesystem;

namespace {

const std::regex& whole() {
  static const std::regex pattern(R"(flight-(-?\d{1,19})-(\d{1,9})\.lcm)");
  return pattern;
}

const std::regex& unfinished() {
  static const std::regex pattern(R"(flight-.*\.lcm\.incomplete-(\d{1,9})-\d+)");
  return pattern;
}

struct Record {
  fs::file_time_type written;
  std::int64_t n = 0;
  fs::path file;
  double bytes = 0;
};

bool is_gone(const std::string& process) {
  return kill(static_cast<pid_t>(std::stol(process)), 0) != 0 && errno == ESRCH;
}

/// Another controller may remove its files meanwhile.
std::vector<Record> records(const fs::path& folder) {
  std::vector<Record> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    std::error_code gone, lost;
    if (!std::regex_match(name, parts, whole()) || !entry.is_regular_file(gone)) continue;
    const Record record{entry.last_write_time(gone), std::stoll(parts[2]), entry.path(),
                        static_cast<double>(entry.file_size(lost))};
    if (!gone && !lost) all.push_back(record);
  }
  std::sort(all.begin(), all.end(), [](const Record& a, const Record& b) {
    return std::pair(a.written, a.n) < std::pair(b.written, b.n);
  });
  return all;
}

void remove_unfinished(const fs::path& folder) {
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (std::regex_match(name, parts, unfinished()) && is_gone(parts[1])) {
      left.push_back(entry.path());
    }
  }
  for (const fs::path& file : left) fs::remove(file);
}

}  // namespace

fs::path next_flight_file(const fs::path& folder, std::int64_t run_id) {
  const std::string run = std::to_string(run_id);
  std::int64_t last = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (std::regex_match(name, parts, whole()) && parts[1] == run) {
      last = std::max<std::int64_t>(last, std::stoll(parts[2]));
    }
  }
  return folder / ("flight-" + run + "-" + std::to_string(last + 1) + ".lcm");
}

void make_room(const fs::path& folder, const FlightBounds& bounds) {
  remove_unfinished(folder);
  const std::vector<Record> all = records(folder);
  double bytes = 0;
  for (const Record& record : all) bytes += record.bytes;
  auto left = static_cast<std::int64_t>(all.size());
  for (const Record& record : all) {
    if (left <= 1 || (left <= bounds.files && bytes <= bounds.bytes)) return;
    fs::remove(record.file);
    bytes -= record.bytes;
    --left;
  }
}

}  // namespace stillframe::controller

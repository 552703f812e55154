#include "report/log/log_difference.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <vector>

#include "core/yaml/input_error.hpp"
#include "msgs/channels.hpp"
#include "report/log/log_events.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::report {

using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;

namespace {

struct Payloads {
  std::vector<std::string> measurements, commands;
};

// Every payload begins with 8 bytes that stand for the type, then the run_id, its first field, and
// the numbers of two processes.
constexpr std::size_t run_id_offset = 8, after_run_id = 16, after_identity = 32;

std::string without_identity(const std::string& payload) {
  std::string copy = payload;
  if (copy.size() >= after_identity) {
    std::fill_n(copy.begin() + run_id_offset, after_identity - run_id_offset, '\0');
  }
  return copy;
}

std::string run_id_of(const std::string& payload) {
  return payload.size() >= after_run_id ? payload.substr(run_id_offset, 8) : payload;
}

Payloads read_payloads(const std::filesystem::path& path) {
  Payloads payloads;
  const auto add = [](std::vector<std::string>& list, std::string_view payload) {
    // A sender repeats its newest message only, so a repeat is always next to what it repeats.
    if (list.empty() || list.back() != payload) list.emplace_back(payload);
  };
  for_each_event(path, [&](const LogEvent& event) {
    if (event.channel == channels::measurement) add(payloads.measurements, event.payload);
    if (event.channel == channels::command) add(payloads.commands, event.payload);
  });
  if (payloads.measurements.empty()) {
    throw InputError(path.string() + ": no " + channels::measurement + " message in this log");
  }
  return payloads;
}

std::string exact(double value) {
  char text[32];
  const auto end = std::to_chars(std::begin(text), std::end(text), value).ptr;
  return {text, end};
}

std::string difference(const char* name, std::int64_t a, std::int64_t b) {
  if (a == b) return {};
  return std::string(name) + ": " + std::to_string(a) + " and " + std::to_string(b);
}

std::string difference(const char* name, const std::vector<double>& a,
                       const std::vector<double>& b) {
  if (a.size() != b.size()) {
    return difference(name, static_cast<std::int64_t>(a.size()),
                      static_cast<std::int64_t>(b.size())) +
           " values";
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(double)) != 0) {
      return std::string(name) + "[" + std::to_string(i) + "]: " + exact(a[i]) + " and " +
             exact(b[i]);
    }
  }
  return {};
}

std::string first_of(std::initializer_list<std::string> candidates) {
  const auto found =
      std::find_if(candidates.begin(), candidates.end(), [](const auto& c) { return !c.empty(); });
  return found == candidates.end() ? "the bytes differ in no field" : *found;
}

std::string field_difference(const measurement_t& a, const measurement_t& b) {
  return first_of({difference("seq", a.seq, b.seq), difference("time_ns", a.time_ns, b.time_ns),
                   difference("floor_acceleration", a.floor_acceleration, b.floor_acceleration),
                   difference("sigma", a.sigma, b.sigma),
                   difference("applied_force", a.applied_force, b.applied_force),
                   difference("frame_acceleration", a.frame_acceleration, b.frame_acceleration)});
}

std::string field_difference(const command_t& a, const command_t& b) {
  return first_of({difference("seq", a.seq, b.seq), difference("time_ns", a.time_ns, b.time_ns),
                   difference("force", a.force, b.force),
                   difference("saturated", std::int64_t{a.saturated}, std::int64_t{b.saturated})});
}

template <typename Message>
std::string describe(const std::string& a, const std::string& b) {
  Message message_a, message_b;
  if (!decode(a, message_a) || !decode(b, message_b)) return "a payload that cannot be decoded";
  return "seq " + std::to_string(message_a.seq) + ": " + field_difference(message_a, message_b);
}

/// Compares message by message, and answers with the first difference or nothing.
template <typename Message>
std::string compare_channel(const std::string& channel, const std::vector<std::string>& a,
                            const std::vector<std::string>& b) {
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    if (without_identity(a[k]) != without_identity(b[k])) {
      return channel + ": message " + std::to_string(k) + ", " + describe<Message>(a[k], b[k]);
    }
  }
  if (a.size() == b.size()) return {};
  return channel + ": " + std::to_string(a.size()) + " and " + std::to_string(b.size()) +
         " messages, the shorter is the beginning of the longer";
}

}  // namespace

LogDifference compare_logs(const std::filesystem::path& path_a,
                           const std::filesystem::path& path_b) {
  const Payloads a = read_payloads(path_a), b = read_payloads(path_b);
  LogDifference result;
  result.n_measurements =
      static_cast<std::int64_t>(std::min(a.measurements.size(), b.measurements.size()));
  result.n_commands = static_cast<std::int64_t>(std::min(a.commands.size(), b.commands.size()));
  result.same_run_id = run_id_of(a.measurements.front()) == run_id_of(b.measurements.front());
  result.first_difference =
      compare_channel<measurement_t>(channels::measurement, a.measurements, b.measurements);
  if (result.first_difference.empty()) {
    result.first_difference = compare_channel<command_t>(channels::command, a.commands, b.commands);
  }
  result.identical = result.first_difference.empty();
  return result;
}

}  // namespace stillframe::report

#include "controller/timing_file.hpp"

#include <sstream>

#include "core/files/whole_file.hpp"

namespace stillframe::controller {

void write_timing_file(const std::filesystem::path& file, const stillframe_msgs::timing_t& counters,
                       const LoopTimes& times) {
  std::ostringstream stream;
  stream << "{\"n_periods\": " << counters.n_periods << ", \"n_late\": " << counters.n_late
         << ", \"n_lost\": " << counters.n_lost << ", \"n_duplicate\": " << counters.n_duplicate
         << ",\n \"wake_up\": " << times.wake_up.to_json()
         << ",\n \"receive\": " << times.receive.to_json()
         << ",\n \"compute\": " << times.compute.to_json()
         << ",\n \"publish\": " << times.publish.to_json() << "}\n";
  write_whole_file(file, stream.str());
}

}  // namespace stillframe::controller

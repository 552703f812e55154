#include "tests/faults/samples.hpp"

#include <fstream>
#include <stdexcept>

namespace stillframe::faults {

namespace {

void write_header(std::ostream& out) {
  out << "plant,sample,state";
  for (const char* what : {"active", "passive", "applied"}) {
    for (int i = 1; i <= 6; ++i) out << ',' << what << '_' << i;
  }
  out << '\n';
}

template <class Values>
void write(std::ostream& out, const Values& values) {
  for (const double value : values) out << ',' << value;
}

}  // namespace

void write_samples(const std::filesystem::path& folder, const std::string& name, const Trace& trace,
                   Workbench& bench) {
  const std::filesystem::path file = folder / (name + ".csv");
  std::ofstream out(file);
  write_header(out);
  std::size_t next = 0;
  std::int32_t state = 0;
  for (std::size_t run = 0; run < trace.runs.size(); ++run) {
    const RunTrace& samples = trace.runs[run];
    const auto passive = bench.passive(static_cast<std::int64_t>(samples.frame.size()));
    for (std::size_t k = 0; k < samples.frame.size(); ++k) {
      for (; next < trace.statuses.size(); ++next) {
        const StatusAt& at = trace.statuses[next];
        if (at.run > run || (at.run == run && at.sample > static_cast<std::int64_t>(k))) break;
        state = at.status.state;
      }
      if (samples.arrival_ns[k] == 0) continue;
      out << run << ',' << k << ',' << state;
      write(out, samples.frame[k]);
      write(out, passive[k]);
      write(out, samples.applied[k]);
      out << '\n';
    }
  }
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace stillframe::faults

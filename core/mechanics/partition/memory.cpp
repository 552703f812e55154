#include "core/mechanics/partition/memory.hpp"

#include <unistd.h>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"

namespace stillframe {

void require_memory(double numbers, const std::string& place, const std::string& of_what) {
  const double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<double>(sysconf(_SC_PAGESIZE)),
               needed = numbers * sizeof(double);
  if (needed <= there) return;
  throw InputError(
      place + ": " + of_what +
      formatted(" would take about %.3g GB of memory, this machine has %.3g GB", needed / 1e9,
                there / 1e9) +
      "; divide fewer beams into fewer parts, or ask for the lowest modes alone (modes --lowest)");
}

}  // namespace stillframe

#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.hpp"

// The function that libFuzzer calls; FUZZ_TARGET is the name of the target.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stillframe::fuzz::FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}

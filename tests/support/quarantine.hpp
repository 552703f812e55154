#pragma once

#include <cstdint>

namespace stillframe::test {

/// Bytes of freed memory that the address sanitizer keeps from being used again (its default,
/// quarantine_size_mb), for tests of how much memory a process takes; 0 without it.
#ifdef __SANITIZE_ADDRESS__
inline constexpr std::int64_t quarantine_bytes = std::int64_t{256} << 20;
#else
inline constexpr std::int64_t quarantine_bytes = 0;
#endif

}  // namespace stillframe::test

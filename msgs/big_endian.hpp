#pragma once

#include <cstdint>

namespace stillframe {

/// A number as LCM writes it, highest byte first. Hot: noexcept, no allocation.
inline std::uint64_t read_big_endian(const char* bytes, int n) noexcept {
  std::uint64_t value = 0;
  for (int i = 0; i < n; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

inline std::int64_t read_int64(const char* bytes) noexcept {
  return static_cast<std::int64_t>(read_big_endian(bytes, 8));
}

inline std::int32_t read_int32(const char* bytes) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(read_big_endian(bytes, 4)));
}

}  // namespace stillframe

#pragma once

#include <cstdint>

namespace stillframe::test {

/// Number of heap allocations made so far by the objects that are linked into this program: malloc,
/// calloc, realloc, aligned forms and operator new. The linker's --wrap brings them here, so shared
/// libraries are not counted, and sanitizers keep working.
std::int64_t allocation_count() noexcept;

}  // namespace stillframe::test

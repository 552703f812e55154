#include "tests/support/allocation_count.hpp"

#include <atomic>
#include <cstddef>

namespace {

std::atomic<std::int64_t> count{0};

}  // namespace

namespace stillframe::test {

std::int64_t allocation_count() noexcept { return count.load(); }

}  // namespace stillframe::test

// The names are the linker's: __wrap_f is called in place of f, __real_f is f.
extern "C" {

void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t n, std::size_t size);
void* __real_realloc(void* memory, std::size_t size);
void* __real_aligned_alloc(std::size_t alignment, std::size_t size);
int __real_posix_memalign(void** memory, std::size_t alignment, std::size_t size);
void* __real__Znwm(std::size_t size);
void* __real__Znam(std::size_t size);

void* __wrap_malloc(std::size_t size) {
  ++count;
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t n, std::size_t size) {
  ++count;
  return __real_calloc(n, size);
}
void* __wrap_realloc(void* memory, std::size_t size) {
  ++count;
  return __real_realloc(memory, size);
}
void* __wrap_aligned_alloc(std::size_t alignment, std::size_t size) {
  ++count;
  return __real_aligned_alloc(alignment, size);
}
int __wrap_posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++count;
  return __real_posix_memalign(memory, alignment, size);
}
void* __wrap__Znwm(std::size_t size) {
  ++count;
  return __real__Znwm(size);
}
void* __wrap__Znam(std::size_t size) {
  ++count;
  return __real__Znam(size);
}
}

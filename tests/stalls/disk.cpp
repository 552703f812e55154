// Preloaded into a process, it makes the disk what a file says whose name is in
// STILLFRAME_TEST_DISK: "hangs", so that nothing is on it before the file says something else, or
// "full".
#include <fcntl.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

namespace {

char word() {
  const char* name = std::getenv("STILLFRAME_TEST_DISK");
  const int file = name == nullptr ? -1 : open(name, O_RDONLY | O_CLOEXEC);
  char first = 0;
  if (file < 0) return first;
  if (read(file, &first, 1) != 1) first = 0;
  close(file);
  return first;
}

}  // namespace

extern "C" int fsync(int file) {
  const timespec pause{.tv_sec = 0, .tv_nsec = 10'000'000};
  while (word() == 'h') nanosleep(&pause, nullptr);
  if (word() != 'f') return fdatasync(file);
  errno = ENOSPC;
  return -1;
}

#pragma once

#include <functional>

namespace stillframe {

/// The frame of every program: runs it, flushes standard output and answers its exit code. What it
/// prints on std::cout and std::cerr goes through printable(), line by line: names and texts come
/// from files and from the bus. If standard output has not taken all that was written to it, says
/// so on standard error, and a code of 0 becomes 1.
int with_standard_output(const char* program, const std::function<int()>& run);

}  // namespace stillframe

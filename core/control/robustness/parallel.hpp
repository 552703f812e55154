#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace stillframe::robustness {

/// Calls work(i, job) for every i from 0 to n - 1, each once, on up to `jobs` threads numbered from
/// 0. An exception ends them all and is thrown again here. Set-up.
template <class Work>
void parallel_for(std::uint64_t n, int jobs, const Work& work) {
  std::atomic<std::uint64_t> next{0};
  std::exception_ptr thrown;
  std::mutex mutex;
  const auto run = [&](int job) {
    try {
      for (std::uint64_t i = next++; i < n; i = next++) work(i, job);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!thrown) thrown = std::current_exception();
      next = n;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int job = 1; job < jobs && static_cast<std::uint64_t>(job) < n; ++job) {
      threads.emplace_back(run, job);
    }
    run(0);
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace stillframe::robustness

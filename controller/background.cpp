#include "controller/background.hpp"

#include <pthread.h>
#include <semaphore.h>

#include <algorithm>
#include <csignal>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

constexpr std::int64_t look_every_ns = 1'000'000;

/// Whoever holds it has the priority of whoever waits for it. Without that, a thread of any
/// priority between the two could keep a job from being given.
class Mutex {
 public:
  Mutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    pthread_mutex_init(&mutex_, &attributes);
    pthread_mutexattr_destroy(&attributes);
  }
  ~Mutex() { pthread_mutex_destroy(&mutex_); }
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;
  void lock() { pthread_mutex_lock(&mutex_); }
  void unlock() { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_{};
};

}  // namespace

/// Outlives the object as long as a job hangs.
struct Background::Shared {
  explicit Shared(std::size_t most) : capacity(most) { sem_init(&something, 0, 0); }
  ~Shared() { sem_destroy(&something); }
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;

  void run() {
    while (std::function<void()> job = next()) {
      try {
        job();
      } catch (const std::exception&) {
      }
    }
  }

  /// Waits for a job; none at the end.
  std::function<void()> next() {
    {
      const std::lock_guard lock(mutex);
      busy = false;
    }
    while (sem_wait(&something) != 0) {
    }
    const std::lock_guard lock(mutex);
    if (jobs.empty()) return nullptr;
    std::function<void()> job = std::move(jobs.front());
    jobs.pop_front();
    busy = true;
    return job;
  }

  const std::size_t capacity;
  Mutex mutex;
  sem_t something{};  ///< one for each job that waits, and one for the end
  std::deque<std::function<void()>> jobs;
  std::int64_t n_dropped = 0;
  bool busy = false;
};

Background::Background(std::size_t capacity)
    : shared_(std::make_shared<Shared>(std::max<std::size_t>(capacity, 1))) {
  // Signals are for the threads that look at the flag they set, and not for one that hangs.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([shared = shared_] { shared->run(); }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Background::~Background() { sem_post(&shared_->something); }

void Background::give(std::function<void()> job) {
  std::function<void()> oldest;  // what it holds is given back outside the lock
  const std::lock_guard lock(shared_->mutex);
  if (shared_->jobs.size() < shared_->capacity) {
    sem_post(&shared_->something);
  } else {
    oldest = std::move(shared_->jobs.front());
    shared_->jobs.pop_front();
    ++shared_->n_dropped;
  }
  shared_->jobs.push_back(std::move(job));
}

bool Background::finish(double limit_s) {
  const std::int64_t until = monotonic_ns() + static_cast<std::int64_t>(limit_s * ns_per_s);
  while (true) {
    {
      const std::lock_guard lock(shared_->mutex);
      if (!shared_->busy && shared_->jobs.empty()) return true;
    }
    if (monotonic_ns() > until) return false;
    sleep_until(monotonic_ns() + look_every_ns);
  }
}

std::int64_t Background::n_dropped() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->n_dropped;
}

}  // namespace stillframe::controller

#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace stillframe::controller {

/// A bounded queue from one thread to one other, without locks. Its places are copies of one object
/// made at construction, and are filled in place, so that nothing is allocated later; an object
/// that does not fit is the producer's to count. Construction is set-up; the rest is hot: noexcept,
/// no allocation.
template <class T>
class Ring {
 public:
  Ring(std::size_t capacity, const T& like) : places_(capacity + 1, like) {}

  /// The producer's: the place to be filled, or none if the ring is full; then push gives it away.
  T* free_place() noexcept {
    const std::size_t in = in_.load(std::memory_order_relaxed);
    return after(in) == out_.load(std::memory_order_acquire) ? nullptr : &places_[in];
  }
  void push() noexcept {
    in_.store(after(in_.load(std::memory_order_relaxed)), std::memory_order_release);
  }

  /// The consumer's: the oldest object, or none if the ring is empty; then pop gives its place
  /// back.
  T* oldest() noexcept {
    const std::size_t out = out_.load(std::memory_order_relaxed);
    return out == in_.load(std::memory_order_acquire) ? nullptr : &places_[out];
  }
  void pop() noexcept {
    out_.store(after(out_.load(std::memory_order_relaxed)), std::memory_order_release);
  }

  /// The producer's: copies a value in; false if the ring is full.
  bool give(const T& value) noexcept {
    T* place = free_place();
    if (place == nullptr) return false;
    *place = value;
    push();
    return true;
  }
  /// The consumer's: copies the oldest object out; false if the ring is empty.
  bool take(T& value) noexcept {
    const T* there = oldest();
    if (there == nullptr) return false;
    value = *there;
    pop();
    return true;
  }

 private:
  std::size_t after(std::size_t place) const noexcept {
    return place + 1 == places_.size() ? 0 : place + 1;
  }

  std::vector<T> places_;
  // On lines of the cache of their own, because each is written by one thread only.
  alignas(64) std::atomic<std::size_t> in_{0};
  alignas(64) std::atomic<std::size_t> out_{0};
};

}  // namespace stillframe::controller

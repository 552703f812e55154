#pragma once

#include "controller/io.hpp"
#include "controller/ring.hpp"

namespace stillframe::controller {

/// Io without sockets, for plant and controller in one program: two rings between the loop's thread
/// and the plant's, which may be the same. Construction is set-up; the rest is hot: noexcept, no
/// allocation.
class InProcessIo : public Io {
 public:
  /// m legs and p accelerations of the floor; room for so many measurements, and commands, that
  /// were not taken yet.
  explicit InProcessIo(Eigen::Index m, std::size_t capacity = 64, Eigen::Index p = 0)
      : measurements_(capacity, {.sigma = Eigen::VectorXd::Zero(m),
                                 .applied = Eigen::VectorXd::Zero(m),
                                 .floor = Eigen::VectorXd::Zero(p)}),
        commands_(capacity, {.force = Eigen::VectorXd::Zero(m)}) {}

  bool receive(Measurement& measurement) noexcept override {
    return take(measurements_, measurement);
  }
  void send(const Command& command) noexcept override { give(commands_, command); }

  /// The plant's ends. False if there is no room, or nothing there.
  bool put(const Measurement& measurement) noexcept { return give(measurements_, measurement); }
  bool take(Command& command) noexcept { return take(commands_, command); }

 private:
  template <class T>
  static bool give(Ring<T>& ring, const T& value) noexcept {
    T* place = ring.free_place();
    if (place == nullptr) return false;
    *place = value;
    ring.push();
    return true;
  }
  template <class T>
  static bool take(Ring<T>& ring, T& value) noexcept {
    const T* oldest = ring.oldest();
    if (oldest == nullptr) return false;
    value = *oldest;
    ring.pop();
    return true;
  }

  Ring<Measurement> measurements_;
  Ring<Command> commands_;
};

}  // namespace stillframe::controller

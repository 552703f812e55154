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
      : measurements_(capacity, measurement_of(m, p)), commands_(capacity, command_of(m)) {}

  bool receive(Measurement& measurement) noexcept override {
    return measurements_.take(measurement);
  }
  void send(const Command& command) noexcept override { commands_.give(command); }

  /// The plant's ends. False if there is no room, or nothing there.
  bool put(const Measurement& measurement) noexcept { return measurements_.give(measurement); }
  bool take(Command& command) noexcept { return commands_.take(command); }

 private:
  Ring<Measurement> measurements_;
  Ring<Command> commands_;
};

}  // namespace stillframe::controller

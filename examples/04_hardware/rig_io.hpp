// What a rig of one's own needs: this class, around the functions of its cards.
#pragma once

#include <cmath>

#include "cards.hpp"
#include "controller/io.hpp"

class RigIo : public stillframe::controller::Io {
 public:
  RigIo(Cards& cards, double rate_hz, std::int64_t start_ns)
      : cards_(cards), period_ns_(1e9 / rate_hz), start_ns_(start_ns) {}

  // The loop asks at its deadline until there is nothing left: the sensors are read then and there.
  bool receive(stillframe::controller::Measurement& m) noexcept override {
    m.received_ns = cards_.now_ns();
    m.seq = std::llround(static_cast<double>(m.received_ns - start_ns_) / period_ns_);
    if (m.seq <= last_seq_) return false;  // one a period
    last_seq_ = m.seq;
    m.time_ns = std::llround(static_cast<double>(m.seq) * period_ns_);
    for (int leg = 0; leg < m.sigma.size(); ++leg) {
      m.sigma(leg) = cards_.read_force(leg);      // N, tension positive
      m.applied(leg) = cards_.read_applied(leg);  // N, read back, or the last one written
    }
    return true;
  }

  void send(const stillframe::controller::Command& command) noexcept override {
    for (int leg = 0; leg < command.force.size(); ++leg) {
      cards_.write_force(leg, command.force(leg));  // must not wait
    }
  }

 private:
  Cards& cards_;
  double period_ns_;
  std::int64_t start_ns_, last_seq_ = -1;
};

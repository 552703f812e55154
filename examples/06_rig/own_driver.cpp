// A driver of one's own, one class in one file: here of a card that is not there, whose legs ring
// at 20 Hz, each with a size of its own. In place of `read_card` and `write_card` stand the calls
// of a card's library; they must not wait.
#include <cmath>
#include <vector>

#include "controller/rig/driver.hpp"
#include "msgs/clock.hpp"

using namespace stillframe::controller;

namespace {

std::vector<double> volts_out;

double read_card(std::size_t leg, double seconds) {
  return volts_out[leg] + std::sin(125.7 * seconds + static_cast<double>(leg));
}
void write_card(std::size_t leg, double volts) { volts_out[leg] = volts; }

class OwnDriver : public Io {
 public:
  explicit OwnDriver(const DriverSetting& setting) : period_ns_(1e9 / setting.sample_rate_hz) {
    volts_out.assign(static_cast<std::size_t>(setting.n_legs), 0.0);
  }

  // The card has a sample at each period; once it was read there is none until the next.
  bool receive(Measurement& m) noexcept override {
    const std::int64_t now = stillframe::monotonic_ns();
    const auto seq = static_cast<std::int64_t>(static_cast<double>(now - start_ns_) / period_ns_);
    if (seq == m_seq_) return false;
    m.seq = m_seq_ = seq;
    m.received_ns = start_ns_ + std::llround(static_cast<double>(seq) * period_ns_);
    for (std::size_t leg = 0; leg < volts_out.size(); ++leg) {
      const auto i = static_cast<Eigen::Index>(leg);
      m.sigma(i) = read_card(leg, static_cast<double>(now - start_ns_) * 1e-9);
      m.applied(i) = volts_out[leg];
    }
    return true;
  }
  void send(const Command& command) noexcept override {
    for (std::size_t leg = 0; leg < volts_out.size(); ++leg) {
      write_card(leg, command.force(static_cast<Eigen::Index>(leg)));
    }
  }

 private:
  double period_ns_;
  std::int64_t start_ns_ = stillframe::monotonic_ns(), m_seq_ = -1;
};

}  // namespace

STILLFRAME_DRIVER(OwnDriver)

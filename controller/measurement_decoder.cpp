#include "controller/measurement_decoder.hpp"

#include <array>

#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"

namespace stillframe::controller {

void MeasurementDecoder::follow(const stillframe_msgs::run_info_t& info) {
  run_id_ = info.run_id;
  plant_instance_ = info.plant_instance;
  message_.n_floor = info.n_floor;
  message_.n_legs = info.n_legs;
  message_.n_frame = info.n_frame;
  message_.floor_acceleration.resize(static_cast<size_t>(info.n_floor));
  message_.sigma.resize(static_cast<size_t>(info.n_legs));
  message_.applied_force.resize(static_cast<size_t>(info.n_legs));
  message_.frame_acceleration.resize(static_cast<size_t>(info.n_frame));
}

MeasurementDecoder::Result MeasurementDecoder::decode(const lcm::ReceiveBuffer& buffer) noexcept {
  const auto identity = identity_of(bytes_of(buffer));
  if (!identity) return Result::malformed;
  if (identity->run_id != run_id_ || identity->plant_instance != plant_instance_) {
    return Result::other_run;
  }
  if (!has_run_sizes(buffer)) return Result::malformed;
  // The sizes are those that the vectors have: nothing is allocated, nothing can throw.
  const auto size = static_cast<int>(buffer.data_size);
  if (message_.decode(buffer.data, 0, size) != size) return Result::malformed;
  return Result::taken;
}

bool MeasurementDecoder::has_run_sizes(const lcm::ReceiveBuffer& buffer) const noexcept {
  constexpr int offset = 8 + 5 * 8;  // fingerprint, run, plant, controller, seq, time
  if (static_cast<int>(buffer.data_size) != message_.getEncodedSize()) return false;
  std::array<std::int32_t, 3> sizes{};
  __int32_t_decode_array(buffer.data, offset, 12, sizes.data(), 3);
  return sizes[0] == message_.n_floor && sizes[1] == message_.n_legs &&
         sizes[2] == message_.n_frame;
}

}  // namespace stillframe::controller

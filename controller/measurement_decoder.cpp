#include "controller/measurement_decoder.hpp"

#include <array>

#include "msgs/lcm_bus.hpp"

namespace stillframe::controller {

void MeasurementDecoder::follow(const stillframe_msgs::run_info_t& info) {
  run_id_ = info.run_id;
  message_.n_floor = info.n_floor;
  message_.n_legs = info.n_legs;
  message_.n_frame = info.n_frame;
  message_.floor_acceleration.resize(static_cast<size_t>(info.n_floor));
  message_.sigma.resize(static_cast<size_t>(info.n_legs));
  message_.applied_force.resize(static_cast<size_t>(info.n_legs));
  message_.frame_acceleration.resize(static_cast<size_t>(info.n_frame));
}

MeasurementDecoder::Result MeasurementDecoder::decode(const lcm::ReceiveBuffer& buffer) noexcept {
  if (!is_of_run(buffer)) return Result::other_run;
  if (!has_run_sizes(buffer) || !stillframe::decode(buffer, message_)) return Result::malformed;
  return Result::taken;
}

bool MeasurementDecoder::is_of_run(const lcm::ReceiveBuffer& buffer) const noexcept {
  constexpr int offset = 8;  // after the fingerprint
  std::int64_t run_id = 0;
  return __int64_t_decode_array(buffer.data, offset, static_cast<int>(buffer.data_size) - offset,
                                &run_id, 1) > 0 &&
         run_id == run_id_;
}

bool MeasurementDecoder::has_run_sizes(const lcm::ReceiveBuffer& buffer) const noexcept {
  constexpr int offset = 8 + 3 * 8;  // fingerprint, run_id, seq, time_ns
  if (static_cast<int>(buffer.data_size) != message_.getEncodedSize()) return false;
  std::array<std::int32_t, 3> sizes{};
  __int32_t_decode_array(buffer.data, offset, 12, sizes.data(), 3);
  return sizes[0] == message_.n_floor && sizes[1] == message_.n_legs &&
         sizes[2] == message_.n_frame;
}

}  // namespace stillframe::controller

#pragma once

#include <cstddef>
#include <tuple>
#include <type_traits>

#include "stillframe_msgs/clock_exchange_t.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::fuzz {

/// Every message of the bus, in an order that inputs of the target `messages` rely on.
using MessageTypes =
    std::tuple<stillframe_msgs::measurement_t, stillframe_msgs::command_t,
               stillframe_msgs::run_info_t, stillframe_msgs::run_state_t, stillframe_msgs::timing_t,
               stillframe_msgs::control_request_t, stillframe_msgs::controller_status_t,
               stillframe_msgs::loop_records_t, stillframe_msgs::loop_checkpoint_t,
               stillframe_msgs::excitation_t, stillframe_msgs::clock_exchange_t>;

inline constexpr std::size_t fingerprint_size = 8;

template <typename Message, std::size_t i = 0>
constexpr std::size_t index_of() {
  if constexpr (std::is_same_v<Message, std::tuple_element_t<i, MessageTypes>>) {
    return i;
  } else {
    return index_of<Message, i + 1>();
  }
}

}  // namespace stillframe::fuzz

#pragma once

// The LCM channels of a run, one type each.
namespace stillframe::channels {

inline constexpr const char* measurement = "SF_MEASUREMENT";  // measurement_t, plant to controller
inline constexpr const char* command = "SF_COMMAND";          // command_t, controller to plant
inline constexpr const char* run_info = "SF_RUN_INFO";        // run_info_t, plant
inline constexpr const char* run_state = "SF_RUN_STATE";      // run_state_t, plant and controller
inline constexpr const char* timing = "SF_TIMING";            // timing_t, plant and controller

// Wall-clock runs only:
inline constexpr const char* request = "SF_REQUEST";        // control_request_t, to the controller
inline constexpr const char* status = "SF_STATUS";          // controller_status_t, controller
inline constexpr const char* loop = "SF_LOOP";              // loop_records_t, controller
inline constexpr const char* checkpoint = "SF_CHECKPOINT";  // loop_checkpoint_t, controller
inline constexpr const char* excitation = "SF_EXCITATION";  // excitation_t, controller

inline constexpr const char* clock = "SF_CLOCK";  // clock_exchange_t, any; between hosts

inline constexpr const char* logger_check =
    "SF_LOGGER_CHECK";  // empty, makes a logger write out what it holds

}  // namespace stillframe::channels

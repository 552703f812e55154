#pragma once

namespace stillframe {

/// From now on SIGINT, SIGTERM and SIGHUP only set a flag, and interrupt waits; a hang-up that was
/// ignored before, as nohup does, stays so. Set-up. Errors: std::system_error.
void catch_stop_signals();

/// From now on a pipe without a reader, and a file that has reached its limit, are errors of what
/// writes there and no longer the end of the process. Set-up. Errors: std::system_error.
void ignore_write_signals();

/// True once a stop signal has come. Hot: noexcept, no allocation.
bool stop_requested() noexcept;

/// For how long what waits may go without looking at it and at the clock.
inline constexpr int look_every_ms = 50;

}  // namespace stillframe

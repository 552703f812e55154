#pragma once

namespace stillframe::controller {

/// From now on SIGINT and SIGTERM only set a flag, and interrupt waits. Set-up.
/// Errors: std::system_error.
void catch_stop_signals();

/// True once SIGINT or SIGTERM has come. Hot: noexcept, no allocation.
bool stop_requested() noexcept;

}  // namespace stillframe::controller

#pragma once

#include "report/log/log_scan.hpp"
#include "report/log/sample_window.hpp"

namespace stillframe::report {

/// scan_log that also hands out every distinct command in the order of seq, those without a logged
/// measurement included. Errors: as scan_log.
LogScan scan_log_with_commands(const std::filesystem::path& path, const ScanSettings& settings,
                               LogVisitor& visitor, SampleWindow::CommandSink commands);

}  // namespace stillframe::report

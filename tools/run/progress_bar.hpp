#pragma once

#include <cstdint>
#include <string>

namespace stillframe::tools {

/// One line on a terminal's standard error that is written over as a run goes on; silent where
/// standard error is no terminal.
class ProgressBar {
 public:
  ProgressBar(std::string what, double sample_rate_hz);
  ~ProgressBar();
  void show(std::int64_t done, std::int64_t all);

 private:
  std::string what_;
  double sample_rate_hz_;
  std::int64_t began_ns_;
  bool terminal_, shown_ = false;
};

}  // namespace stillframe::tools

#pragma once

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "report/export/log_export.hpp"

namespace stillframe::report {

/// Takes from a log what ExportSettings ask for, and counts it.
class ChosenRows : public LogVisitor {
 public:
  explicit ChosenRows(const ExportSettings& settings) : settings_(settings) {}

  void begin(const stillframe_msgs::run_info_t& info) override {
    summary_.columns = choose_columns(info, settings_.channels);
    ready(info);
  }

  void samples(const SampleBlock& block) override {
    // Times increase with seq, but those of a damaged message may not.
    for (Eigen::Index k = 0; k < block.n_samples(); ++k) {
      const double time = block.time_s(k);
      if (!run_has_begun_) run_first_s_ = time;
      run_has_begun_ = true;
      run_last_s_ = time;
      if (!(time >= settings_.from_s && time <= settings_.to_s)) continue;
      if (summary_.n_rows == 0) summary_.first_s = time;
      summary_.last_s = time;
      row(block, k);
      ++summary_.n_rows;
    }
  }

  /// Reads the log; `begin` to `end` is the share of the whole work that this is.
  void read(const std::filesystem::path& log, double begin = 0, double end = 1) {
    ScanSettings scan;
    scan.run_id = settings_.run_id;
    scan.plant = settings_.plant;
    if (settings_.progress) {
      scan.progress = [&](double share) { settings_.progress(begin + share * (end - begin)); };
    }
    summary_.scan = scan_log(log, scan, *this);
    if (summary_.n_rows == 0) {
      throw InputError(
          log.string() +
          formatted(": no sample between --from and --to; the run goes from %.6g to %.6g s",
                    run_first_s_, run_last_s_));
    }
  }

  ExportSummary& summary() { return summary_; }

 protected:
  virtual void ready(const stillframe_msgs::run_info_t& /*info*/) {}
  /// One row that was chosen; it is number summary().n_rows.
  virtual void row(const SampleBlock& /*block*/, Eigen::Index /*k*/) {}

 private:
  const ExportSettings& settings_;
  ExportSummary summary_;
  bool run_has_begun_ = false;
  double run_first_s_ = 0, run_last_s_ = 0;
};

}  // namespace stillframe::report

#include "report/log/run_log.hpp"

#include <algorithm>

#include "report/log/scan_commands.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using stillframe_msgs::run_info_t;

namespace {

/// A log that is read whole takes much memory anyway, so late messages may be very late.
constexpr std::int64_t reorder_samples = 1 << 16;

/// Rows that come part by part, without a copy for every part.
class Rows {
 public:
  void reserve(Index n_rows, Index n_columns) { values_.resize(n_rows, n_columns); }
  template <typename Part>
  void add(const Part& part) {
    if (filled_ + part.rows() > values_.rows()) {
      values_.conservativeResize(std::max(filled_ + part.rows(), 2 * values_.rows()),
                                 Eigen::NoChange);
    }
    values_.middleRows(filled_, part.rows()) = part;
    filled_ += part.rows();
  }
  MatrixXd take() {
    if (filled_ < values_.rows()) values_.conservativeResize(filled_, Eigen::NoChange);
    return std::move(values_);
  }

 private:
  MatrixXd values_;
  Index filled_ = 0;
};

class Collector : public LogVisitor {
 public:
  explicit Collector(const std::filesystem::path& path) {
    std::error_code ignored;
    const auto size = std::filesystem::file_size(path, ignored);
    if (!ignored) file_size_ = static_cast<std::int64_t>(size);
  }

  void begin(const run_info_t& info) override {
    // n_samples is only a promise, and a damaged one could be of any size; the file cannot hold
    // more samples than numbers.
    const std::int64_t values = info.n_floor + 2 * info.n_legs + info.n_frame;
    const std::int64_t most = file_size_ / (8 * (values + 1));
    const auto n = static_cast<Index>(std::clamp<std::int64_t>(info.n_samples, 0, most));
    seq_.reserve(static_cast<std::size_t>(n));
    command_seq_.reserve(static_cast<std::size_t>(n));
    time_.reserve(n, 1);
    floor_.reserve(n, info.n_floor);
    sigma_.reserve(n, info.n_legs);
    applied_.reserve(n, info.n_legs);
    frame_.reserve(n, info.n_frame);
    force_.reserve(n, info.n_legs);
  }

  void samples(const SampleBlock& block) override {
    for (Index k = 0; k < block.n_samples(); ++k) seq_.push_back(block.first_seq + k);
    time_.add(block.time_s);
    floor_.add(block.floor_acceleration);
    sigma_.add(block.sigma);
    applied_.add(block.applied_force);
    frame_.add(block.frame_acceleration);
  }

  void command(std::int64_t seq, const Eigen::VectorXd& force) {
    command_seq_.push_back(seq);
    force_.add(force.transpose());
  }

  void move_to(RunLog& log) {
    log.seq = std::move(seq_);
    log.time_s = time_.take();
    log.floor_acceleration = floor_.take();
    log.sigma = sigma_.take();
    log.applied_force = applied_.take();
    log.frame_acceleration = frame_.take();
    log.command_seq = std::move(command_seq_);
    log.command_force = force_.take();
  }

 private:
  std::int64_t file_size_ = 0;
  std::vector<std::int64_t> seq_, command_seq_;
  Rows time_, floor_, sigma_, applied_, frame_, force_;
};

}  // namespace

RunLog read_run_log(const std::filesystem::path& path, std::optional<std::int64_t> run_id) {
  ScanSettings settings;
  settings.run_id = run_id;
  settings.reorder_samples = reorder_samples;
  Collector collector(path);
  LogScan scan = scan_log_with_commands(
      path, settings, collector,
      [&](std::int64_t seq, const Eigen::VectorXd& force) { collector.command(seq, force); });
  RunLog log;
  collector.move_to(log);
  log.info = std::move(scan.info);
  log.n_saturated = scan.n_saturated;
  log.measurements = std::move(scan.measurements);
  log.commands = std::move(scan.commands);
  log.plant_timing = std::move(scan.plant_timing);
  log.controller_timing = std::move(scan.controller_timing);
  log.log_duration_s = scan.log_duration_s;
  log.n_damaged = scan.n_damaged + scan.n_undecodable;
  log.unread_bytes = scan.unread_bytes;
  return log;
}

}  // namespace stillframe::report

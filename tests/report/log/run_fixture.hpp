#pragma once

#include <bit>
#include <cstring>
#include <random>

#include "report/log/log_scan.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "tests/report/sample_log.hpp"

namespace stillframe::report {

/// Bits of numbers, so that NaN equals NaN and 0 differs from -0.
inline std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> result;
  for (const double value : values) result.push_back(std::bit_cast<std::uint64_t>(value));
  return result;
}

template <typename Row>
std::vector<std::uint64_t> row_bits(const Row& row) {
  std::vector<std::uint64_t> result;
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    result.push_back(std::bit_cast<std::uint64_t>(static_cast<double>(row(i))));
  }
  return result;
}

/// Keeps all that a scan hands out, and checks that it comes as promised.
class Keeper : public LogVisitor {
 public:
  struct Sample {
    double time_s = 0;
    std::vector<std::uint64_t> floor, sigma, applied, frame, command;
  };
  std::map<std::int64_t, Sample> samples_by_seq;
  std::vector<Eigen::Index> block_sizes;
  std::vector<std::int64_t> block_begins, periods;
  stillframe_msgs::run_info_t info;
  int n_begins = 0;
  bool is_orderly = true;  ///< begin first, blocks in increasing order of seq

  void begin(const stillframe_msgs::run_info_t& own) override {
    info = own;
    is_orderly = is_orderly && n_begins == 0 && samples_by_seq.empty();
    ++n_begins;
  }
  void samples(const SampleBlock& b) override {
    is_orderly = is_orderly && n_begins == 1 && b.n_samples() > 0 && b.first_seq >= next_;
    for (Eigen::Index k = 0; k < b.n_samples(); ++k) {
      samples_by_seq[b.first_seq + k] = {b.time_s(k),
                                         row_bits(b.floor_acceleration.row(k)),
                                         row_bits(b.sigma.row(k)),
                                         row_bits(b.applied_force.row(k)),
                                         row_bits(b.frame_acceleration.row(k)),
                                         row_bits(b.command_force.row(k))};
    }
    block_sizes.push_back(b.n_samples());
    block_begins.push_back(b.first_seq);
    next_ = b.first_seq + b.n_samples();
  }
  void period(const stillframe_msgs::loop_record_t& record) override {
    periods.push_back(record.period);
  }

 private:
  std::int64_t next_ = 0;
};

/// A whole run with everything that a log of ours holds, its numbers arbitrary bit patterns: three
/// run_info, measurements and commands, records and status of a controller, timing, and a foreign
/// channel.
inline void write_full_run(LogWriter& log, std::int64_t run_id, std::int64_t n_samples,
                           std::mt19937_64& random) {
  const auto arbitrary = [&random](std::vector<double>& values) {
    for (double& value : values) value = std::bit_cast<double>(random());
  };
  for (int copy = 0; copy < 3; ++copy) {
    auto info = sample_info(run_id, n_samples);
    info.scene_text = "title: a scene\n# \xC3\xA9t\xC3\xA9\n";
    log.write(channels::run_info, info);
  }
  stillframe_msgs::run_state_t state{};
  state.run_id = run_id;
  state.source = "plant";
  log.write(channels::run_state, state);
  for (std::int64_t seq = 0; seq < n_samples; ++seq) {
    auto measurement = sample_measurement(run_id, seq);
    arbitrary(measurement.floor_acceleration), arbitrary(measurement.sigma);
    arbitrary(measurement.applied_force), arbitrary(measurement.frame_acceleration);
    log.write(channels::measurement, measurement);
    auto command = sample_command(run_id, seq);
    arbitrary(command.force);
    log.write(channels::command, command);
    if (seq % 50 == 49) {
      stillframe_msgs::loop_records_t records{};
      records.run_id = run_id;
      records.n_records = 2;
      records.records.resize(2);
      for (int i = 0; i < 2; ++i) {
        auto& record = records.records[static_cast<std::size_t>(i)];
        record.period = seq - 1 + i;
        record.n_legs = 3;
        record.sigma = record.applied = record.force = {1, 2, 3};
      }
      log.write(channels::loop, records);
      stillframe_msgs::controller_status_t status{};
      status.run_id = run_id;
      status.text = "active";
      status.n_periods = seq;
      log.write(channels::status, status);
      log.write_bytes("CAMERA", std::vector<char>(random() % 300, 'c'));
    }
  }
  stillframe_msgs::timing_t timing{};
  timing.run_id = run_id;
  timing.source = "plant";
  log.write(channels::timing, timing);
}

}  // namespace stillframe::report

#include "report/analysis/log_analyser.hpp"

#include <algorithm>

#include "core/yaml/input_error.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using stillframe_msgs::run_info_t;

namespace {

Index column_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw InputError("the log has no frame acceleration called '" + name + "'");
  }
  return found - names.begin();
}

/// One direction while the log is read.
struct Axis {
  std::string name;
  Index floor_column, frame_column;
  SignalAnalyser floor, frame;
};

class Analyser : public LogVisitor {
 public:
  explicit Analyser(const std::function<AnalysisPlan(const run_info_t&)>& plan_of)
      : plan_of_(plan_of) {}

  void begin(const run_info_t& info) override {
    plan_ = plan_of_(info);
    const double rate = info.sample_rate_hz;
    for (const AxisPlan& axis : plan_.axes) {
      axes_.push_back({axis.name, column_of(info.frame_names, axis.floor),
                       column_of(info.frame_names, axis.frame), SignalAnalyser(rate),
                       SignalAnalyser(rate)});
    }
    for (const std::string& leg : info.leg_names) legs_.emplace_back(leg, rate);
    plan_responses(info);
  }

  void samples(const SampleBlock& block) override {
    if (block.first_seq > next_seq_ && started_) skip(block.first_seq - next_seq_);
    started_ = true;
    next_seq_ = block.first_seq + block.n_samples();
    for (Axis& axis : axes_) {
      axis.floor.add(block.frame_acceleration.col(axis.floor_column));
      axis.frame.add(block.frame_acceleration.col(axis.frame_column));
    }
    for (std::size_t leg = 0; leg < legs_.size(); ++leg) {
      const auto column = static_cast<Index>(leg);
      legs_[leg].add(block.applied_force.col(column), block.sigma.col(column),
                     block.command_force.col(column));
    }
    if (matrix_) {
      matrix_->add(block.first_seq, block.floor_acceleration,
                   block.frame_acceleration.leftCols(plan_.n_outputs));
    }
    if (axis_matrix_) add_axes(block);
  }

  void period(const stillframe_msgs::loop_record_t& record) override {
    wake_up_.add(record.wake_up_ns - record.deadline_ns);
    compute_.add(record.computed_ns - record.wake_up_ns);
  }

  LogAnalysis finish(LogScan scan) {
    LogAnalysis result;
    result.scan = std::move(scan);
    for (const Axis& axis : axes_) {
      AxisAnalysis done{axis.name, axis.floor.finish(), axis.frame.finish(), {}};
      if (!plan_.multisine) done.shocks = find_shocks(done.floor.levels, done.frame.levels);
      result.axes.push_back(std::move(done));
    }
    for (const LegAnalyser& leg : legs_) result.legs.push_back(leg.finish());
    if (matrix_) result.matrix = matrix_->finish();
    if (axis_matrix_) result.axis_matrix = axis_matrix_->finish();
    result.wake_up = std::move(wake_up_);
    result.compute = std::move(compute_);
    return result;
  }

 private:
  void plan_responses(const run_info_t& info) {
    BroadbandPlan broadband{
        .sample_rate_hz = info.sample_rate_hz,
        .n_inputs = info.n_floor,
        .n_outputs = plan_.n_outputs,
        .frequencies_hz = plan_.frequencies_hz,
        .segment_s = plan_.segment_s,
        .expected_s = static_cast<double>(info.n_samples) / info.sample_rate_hz};
    if (broadband.expected_s > 0) {
      broadband.segment_s = std::min(broadband.segment_s, broadband.expected_s);
    }
    if (plan_.n_outputs > 0 && info.n_floor > 0) {
      const ResponseSignals signals{
          info.floor_names, {info.frame_names.begin(), info.frame_names.begin() + plan_.n_outputs}};
      if (plan_.multisine) {
        matrix_ = std::make_unique<ResponseAnalyser>(signals, *plan_.multisine);
      } else {
        matrix_ = std::make_unique<ResponseAnalyser>(signals, broadband);
      }
    }
    if (!axes_.empty() && !plan_.multisine) {
      ResponseSignals signals;
      for (const AxisPlan& axis : plan_.axes) {
        signals.inputs.push_back(axis.floor);
        signals.outputs.push_back(axis.frame);
      }
      broadband.n_inputs = broadband.n_outputs = static_cast<Index>(axes_.size());
      axis_matrix_ = std::make_unique<ResponseAnalyser>(signals, broadband);
    }
  }

  void skip(std::int64_t n) {
    for (Axis& axis : axes_) {
      axis.floor.skip(n);
      axis.frame.skip(n);
    }
    for (LegAnalyser& leg : legs_) leg.skip(n);
  }

  void add_axes(const SampleBlock& block) {
    MatrixXd floors(block.n_samples(), static_cast<Index>(axes_.size())), frames = floors;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      floors.col(static_cast<Index>(a)) = block.frame_acceleration.col(axes_[a].floor_column);
      frames.col(static_cast<Index>(a)) = block.frame_acceleration.col(axes_[a].frame_column);
    }
    axis_matrix_->add(block.first_seq, floors, frames);
  }

  const std::function<AnalysisPlan(const run_info_t&)>& plan_of_;
  AnalysisPlan plan_;
  std::vector<Axis> axes_;
  std::vector<LegAnalyser> legs_;
  std::unique_ptr<ResponseAnalyser> matrix_, axis_matrix_;
  DurationHistogram wake_up_, compute_;
  std::int64_t next_seq_ = 0;
  bool started_ = false;
};

}  // namespace

LogAnalysis analyse_log(const std::filesystem::path& path, const ScanSettings& settings,
                        const std::function<AnalysisPlan(const run_info_t&)>& plan_of) {
  Analyser analyser(plan_of);
  LogScan scan = scan_log(path, settings, analyser);
  return analyser.finish(std::move(scan));
}

}  // namespace stillframe::report

#include "report/analysis/log_analyser.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/infinity.hpp"
#include "report/verdict/acceptance.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using stillframe_msgs::run_info_t;

namespace {

Index column_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw InputError("the log has no frame acceleration called '" + name + "'");
  }
  return found - names.begin();
}

/// What forces do to an acceleration, and what is left of it, while the log is read.
struct ForcesPower {
  ForcesPower(double rate_hz, double lowest_hz, std::int64_t n)
      : by_forces(rate_hz, lowest_hz, n), undisturbed(rate_hz, lowest_hz, n) {}
  RunningPower by_forces, undisturbed;

  void skip(std::int64_t n) {
    by_forces.skip(n);
    undisturbed.skip(n);
  }
  ForcesPart finish() const { return {by_forces.finish(), undisturbed.finish()}; }
};

/// One direction while the log is read.
struct Axis {
  std::string name;
  Index floor_column, frame_column;
  SignalAnalyser floor, frame;
  RunningPower unexplained;
  ForcesPower forces;
};

/// An acceleration by itself while the log is read.
struct Frame {
  Index column;
  SignalAnalyser motion;
  ForcesPower forces;
};

/// What the model makes of the floor, sample by sample, and since when its state is that of the
/// run: from the beginning of a run, which is at rest, or when what it did not know has died away.
class FloorResponse {
 public:
  explicit FloorResponse(const RunModel& model)
      : response_(model.late ? LoopResponse(*model.late) : LoopResponse(model.loop)) {
    constexpr double forgotten = 1e-4;  // of the state
    const double radius = model.loop.n_exogenous > 0 ? 1 : spectral_radius(model.loop);
    if (radius < 1) settling_ = std::log(forgotten) / std::log(radius);
  }

  /// The next rows of floor inputs: what the outputs are.
  MatrixXd follow(const MatrixXd& inputs) {
    if (inputs.rows() > 0) last_ = inputs.bottomRows(1);
    return response_.follow(inputs);
  }

  /// n samples are missing before a row of inputs: a few are put in as LocalPolynomial does.
  void skip(std::int64_t n, const Eigen::RowVectorXd& behind) {
    if (n > largest_filled_gap || last_.size() == 0) {
      response_.rest_until(response_.next() + n);
      unknown_ = settling_;
      return;
    }
    MatrixXd between(n, behind.size());
    for (Index m = 0; m < n; ++m) {
      between.row(m) =
          last_ + (behind - last_) * (static_cast<double>(m + 1) / static_cast<double>(n + 1));
    }
    follow(between);
  }

  /// How many of the next n rows are not to be believed.
  Index doubtful(Index n) {
    const auto taken = static_cast<Index>(std::min(std::ceil(unknown_), static_cast<double>(n)));
    unknown_ -= static_cast<double>(taken);
    return taken;
  }

 private:
  LoopResponse response_;
  Eigen::RowVectorXd last_;
  double settling_ = infinity;  ///< samples
  double unknown_ = 0;          ///< samples still to come
};

/// An identified response and what the same estimate makes of the forces' part alone: where their
/// motion is as smooth as the floor's it is taken for the floor's doing, and no remainder tells. It
/// has been taken off but for what the model of it is in doubt, which widens the bands.
IdentifiedResponse with_doubt(IdentifiedResponse found, ResponseAnalyser* of_forces) {
  if (of_forces == nullptr || !found.response) return found;
  const IdentifiedResponse by_forces = of_forces->finish();
  if (!by_forces.response) return found;
  for (std::size_t l = 0; l < found.response->T.size(); ++l) {
    // Bands are of two standard deviations.
    const MatrixXd wrong = doubt_of_forces / 2 * by_forces.response->T[l].cwiseAbs();
    const VectorXd weight = found.response->input_weight[l].diagonal().real();
    for (Index i = 0; i < wrong.rows(); ++i) {
      found.response->noise[l](i, i) +=
          (wrong.row(i).transpose().array().square() / weight.array()).maxCoeff();
    }
  }
  return found;
}

class Analyser : public LogVisitor {
 public:
  explicit Analyser(const std::function<AnalysisPlan(const run_info_t&)>& plan_of)
      : plan_of_(plan_of) {}

  void begin(const run_info_t& info) override {
    plan_ = plan_of_(info);
    info_ = info;
    floor_ = FloorSamples(info);
    for (const AxisPlan& axis : plan_.axes) {
      column_of(info.frame_names, axis.floor);  // an error now and not behind the first block
      column_of(info.frame_names, axis.frame);
    }
    for (const std::string& name : plan_.frames) column_of(info.frame_names, name);
    if (plan_.axis_signals.output.empty()) plan_.axis_signals = signals_by_name(plan_.axes);
    for (const std::string& name : axis_signals().inputs) {
      floor_columns_.push_back(column_of(info.frame_names, name));
    }
    for (const std::string& name : plan_.axis_signals.dependent_floors) {
      floor_columns_.push_back(column_of(info.frame_names, name));
    }
    for (const std::string& name : axis_signals().outputs) {
      frame_columns_.push_back(column_of(info.frame_names, name));
    }
    if (plan_.model && !plan_.multisine) model_.emplace(*plan_.model);
    if (plan_.forces) forces_.emplace(*plan_.forces);
    plan_responses(info);
  }

  void samples(const SampleBlock& block) override {
    // What follows the floor and the forces does so from the beginning on.
    const MatrixXd predicted = predict(block);
    MatrixXd by_forces;
    if (forces_) by_forces = forces_->at(block.first_seq, block.n_samples());
    if (!started_) start(block.time_s(0));
    if (block.first_seq > next_seq_ && started_) skip(block.first_seq - next_seq_);
    started_ = true;
    next_seq_ = block.first_seq + block.n_samples();
    floor_.add(block);
    if (model_) look_for_turns(block);
    const auto n_before = [&](std::int64_t seq) {
      return static_cast<Index>(
          std::clamp<std::int64_t>(seq - block.first_seq, 0, block.n_samples()));
    };
    const Index first = n_before(plan_.judged_from), end = n_before(plan_.judged_until);
    if (first > 0) show(rows(block, 0, first));
    if (end > first) {
      const Index n = end - first;
      if (n_judged_ == 0) judged_from_s_ = block.time_s(first);
      n_judged_ += n;
      judge(n < block.n_samples() ? rows(block, first, n) : block,
            predicted.middleRows(model_ ? first : 0, model_ ? n : 0),
            by_forces.middleRows(forces_ ? first : 0, forces_ ? n : 0));
    }
    if (end < block.n_samples()) show(rows(block, end, block.n_samples() - end));
  }

  void period(const stillframe_msgs::loop_record_t& record) override {
    wake_up_.add(record.wake_up_ns - record.deadline_ns);
    compute_.add(record.computed_ns - record.wake_up_ns);
    ++n_periods_;
    // In the order of Defect in controller/policy.hpp: none, missing, then what was there and bad.
    if (record.defect > 1) ++n_discarded_;
    if (record.sent) ++n_commanded_;
  }

  LogAnalysis finish(LogScan scan) {
    LogAnalysis result;
    result.scan = std::move(scan);
    result.floor = std::move(floor_);
    result.axis_signals = plan_.axis_signals;
    result.forces_unknown = plan_.forces_unknown;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const Axis& axis = axes_[a];
      AxisAnalysis done{.name = axis.name,
                        .floor = axis.floor.finish(),
                        .frame = axis.frame.finish(),
                        .unexplained = {},
                        .unexplained_missing = unexplained_missing(a),
                        .forces = {},
                        .shocks = {}};
      if (done.unexplained_missing.empty()) done.unexplained = axis.unexplained.finish();
      if (forces_) done.forces = axis.forces.finish();
      if (!plan_.multisine)
        done.shocks = find_shocks(done.floor.levels, done.frame.levels, judged_from_s_);
      result.axes.push_back(std::move(done));
    }
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      result.frames.push_back({plan_.frames[f], frames_[f].motion.finish(), {}});
      if (forces_) result.frames.back().forces = frames_[f].forces.finish();
    }
    for (const LegAnalyser& leg : legs_) result.legs.push_back(leg.finish());
    if (matrix_) result.matrix = with_doubt(matrix_->finish(), forces_matrix_.get());
    if (result.matrix && plan_.multisine &&
        (plan_.judged_from > plan_.multisine->window_begin(0) + 1 ||
         plan_.judged_until < plan_.multisine->n_samples())) {
      const auto seconds = [&](std::int64_t seq) {
        return formatted("%.4g s", static_cast<double>(seq) / info_.sample_rate_hz);
      };
      result.matrix->response.reset();
      result.matrix->missing =
          "the steady parts of the multisine begin at " +
          seconds(plan_.multisine->window_begin(0)) + " and end at " +
          seconds(plan_.multisine->n_samples()) + ", and the loop held the frame from " +
          seconds(plan_.judged_from) +
          (plan_.judged_until < next_seq_ ? " to " + seconds(plan_.judged_until) : " on");
    }
    if (axis_matrix_) {
      result.axis_matrix = with_doubt(axis_matrix_->finish(), forces_axis_matrix_.get());
    }
    result.judged_from = plan_.judged_from;
    result.judged_until = std::min(plan_.judged_until, next_seq_);
    result.n_judged = n_judged_;
    result.wake_up = std::move(wake_up_);
    result.compute = std::move(compute_);
    result.n_periods = n_periods_;
    result.n_discarded = n_discarded_;
    result.n_commanded = n_commanded_;
    return result;
  }

 private:
  /// What is announced; 0: not known.
  std::int64_t n_to_judge() const {
    return std::max<std::int64_t>(
        0, std::min(info_.n_samples, plan_.judged_until) - plan_.judged_from);
  }

  static SampleBlock rows(const SampleBlock& block, Index first, Index n) {
    const auto of = [&](const MatrixXd& M) { return M.middleRows(first, n); };
    return {.first_seq = block.first_seq + first,
            .time_s = block.time_s.segment(first, n),
            .floor_acceleration = of(block.floor_acceleration),
            .sigma = of(block.sigma),
            .applied_force = of(block.applied_force),
            .frame_acceleration = of(block.frame_acceleration),
            .command_force = of(block.command_force),
            .excitation = of(block.excitation)};
  }

  /// Samples before or behind those that are judged.
  void show(const SampleBlock& block) {
    for (Axis& axis : axes_) {
      axis.floor.show(block.frame_acceleration.col(axis.floor_column));
      axis.frame.show(block.frame_acceleration.col(axis.frame_column));
    }
    for (Frame& frame : frames_) frame.motion.show(block.frame_acceleration.col(frame.column));
    for (std::size_t leg = 0; leg < legs_.size(); ++leg) {
      legs_[leg].show(block.applied_force.col(static_cast<Index>(leg)));
    }
  }

  void judge(const SampleBlock& block, const MatrixXd& predicted, const MatrixXd& by_forces) {
    if (model_) add_unexplained(block, predicted);
    MatrixXd undisturbed;
    if (forces_) {
      undisturbed = block.frame_acceleration - by_forces;
      add_forces(by_forces, undisturbed);
    }
    const MatrixXd& by_floor = forces_ ? undisturbed : block.frame_acceleration;
    for (Axis& axis : axes_) {
      axis.floor.add(block.frame_acceleration.col(axis.floor_column));
      axis.frame.add(block.frame_acceleration.col(axis.frame_column));
    }
    for (Frame& frame : frames_) frame.motion.add(block.frame_acceleration.col(frame.column));
    for (std::size_t leg = 0; leg < legs_.size(); ++leg) {
      const auto column = static_cast<Index>(leg);
      legs_[leg].add(block.applied_force.col(column), block.sigma.col(column),
                     block.command_force.col(column));
    }
    if (matrix_) {
      matrix_->add(block.first_seq, block.floor_acceleration, by_floor.leftCols(plan_.n_outputs),
                   predicted.leftCols(model_ ? plan_.n_outputs : 0));
    }
    if (forces_matrix_) {
      forces_matrix_->add(block.first_seq, block.floor_acceleration,
                          by_forces.leftCols(plan_.n_outputs));
    }
    if (axis_matrix_) add_axes(block, by_floor, predicted, by_forces);
  }

  /// Histories are on plant time, which is known with the first samples.
  void start(double first_time_s) {
    const double rate = info_.sample_rate_hz;
    const std::int64_t n = n_to_judge();
    for (const AxisPlan& axis : plan_.axes) {
      axes_.push_back({axis.name, column_of(info_.frame_names, axis.floor),
                       column_of(info_.frame_names, axis.frame),
                       SignalAnalyser(rate, first_time_s, plan_.lowest_hz, n),
                       SignalAnalyser(rate, first_time_s, plan_.lowest_hz, n),
                       RunningPower(rate, plan_.lowest_hz, n),
                       ForcesPower(rate, plan_.lowest_hz, n)});
    }
    for (const std::string& name : plan_.frames) {
      frames_.push_back({column_of(info_.frame_names, name),
                         SignalAnalyser(rate, first_time_s, plan_.lowest_hz, n),
                         ForcesPower(rate, plan_.lowest_hz, n)});
    }
    for (const std::string& leg : info_.leg_names) legs_.emplace_back(leg, rate, first_time_s);
  }

  void plan_responses(const run_info_t& info) {
    BroadbandPlan broadband{.sample_rate_hz = info.sample_rate_hz,
                            .n_inputs = info.n_floor,
                            .n_outputs = plan_.n_outputs,
                            .frequencies_hz = plan_.frequencies_hz,
                            .segment_s = plan_.segment_s,
                            .expected_s = static_cast<double>(n_to_judge()) / info.sample_rate_hz};
    if (broadband.expected_s > 0) {
      broadband.segment_s = std::min(broadband.segment_s, broadband.expected_s);
    }
    broadband.input_noise = plan_.floor_noise;
    if (plan_.n_outputs > 0 && info.n_floor > 0) {
      const ResponseSignals signals{
          info.floor_names, {info.frame_names.begin(), info.frame_names.begin() + plan_.n_outputs}};
      if (plan_.multisine) {
        matrix_ = std::make_unique<ResponseAnalyser>(signals, *plan_.multisine);
        if (forces_) forces_matrix_ = std::make_unique<ResponseAnalyser>(signals, *plan_.multisine);
      } else {
        matrix_ = std::make_unique<ResponseAnalyser>(
            signals, broadband,
            plan_.model ? plan_.model->matrix : std::vector<Eigen::MatrixXcd>{});
        if (forces_) forces_matrix_ = std::make_unique<ResponseAnalyser>(signals, broadband);
      }
    }
    if (!plan_.axes.empty() && !plan_.multisine) {
      broadband.n_inputs = std::ssize(axis_signals().inputs);
      broadband.n_outputs = std::ssize(axis_signals().outputs);
      broadband.input_noise.reset();  // of channels of their own
      axis_matrix_ = std::make_unique<ResponseAnalyser>(
          axis_signals(), broadband,
          plan_.model ? plan_.model->axes : std::vector<Eigen::MatrixXcd>{},
          plan_.axis_signals.dependent_floors);
      if (forces_) {
        forces_axis_matrix_ = std::make_unique<ResponseAnalyser>(axis_signals(), broadband);
      }
    }
  }

  void skip(std::int64_t n) {
    if (n_judged_ == 0 || next_seq_ >= plan_.judged_until) return skip_shown(n);
    for (Axis& axis : axes_) {
      axis.floor.skip(n);
      axis.frame.skip(n);
      axis.unexplained.skip(n);
      axis.forces.skip(n);
    }
    for (Frame& frame : frames_) {
      frame.motion.skip(n);
      frame.forces.skip(n);
    }
    for (LegAnalyser& leg : legs_) leg.skip(n);
  }

  void skip_shown(std::int64_t n) {
    for (Axis& axis : axes_) {
      axis.floor.skip_shown(n);
      axis.frame.skip_shown(n);
    }
    for (Frame& frame : frames_) frame.motion.skip_shown(n);
    for (LegAnalyser& leg : legs_) leg.skip(n);
  }

  /// What the model makes of the block's floor, an output a column; nothing without a model.
  MatrixXd predict(const SampleBlock& block) {
    if (!model_) return {};
    const std::int64_t missing = block.first_seq - next_seq_;  // 0 is the first
    if (missing > 0) model_->skip(missing, block.floor_acceleration.row(0));
    return model_->follow(block.floor_acceleration);
  }

  void add_unexplained(const SampleBlock& block, const MatrixXd& predicted) {
    const Index doubtful = model_->doubtful(block.n_samples()), n = block.n_samples() - doubtful;
    n_explained_ += n;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      axes_[a].unexplained.skip(doubtful);
      const auto column = plan_.n_outputs + plan_.axis_signals.output[a];
      axes_[a].unexplained.add(block.frame_acceleration.col(axes_[a].frame_column).tail(n) -
                               predicted.col(column).tail(n));
    }
  }

  void add_forces(const MatrixXd& by_forces, const MatrixXd& undisturbed) {
    const auto add = [&](ForcesPower& forces, Index column) {
      forces.by_forces.add(by_forces.col(column));
      forces.undisturbed.add(undisturbed.col(column));
    };
    for (Axis& axis : axes_) add(axis.forces, axis.frame_column);
    for (Frame& frame : frames_) add(frame.forces, frame.column);
  }

  std::string unexplained_missing(std::size_t axis) const {
    if (!model_) {
      return plan_.unmodelled.empty() ? "there is no model of a multisine run" : plan_.unmodelled;
    }
    if (2 * n_explained_ <= n_judged_) {
      return "the log has no beginning or has gaps, and what the loop did there it has not "
             "forgotten in over half of what is left";
    }
    const auto& leans = plan_.model->leans_on_rigid;
    if (axis >= leans.size() || !leans[axis]) return "";
    if (plan_.model->moved_apart) {
      return "the floor moves axes and single inputs at once, and how it moves where no input "
             "measures it is not known";
    }
    const double allowed = std::pow(10, largest_input_difference_db / 20) - 1;
    const double strayed = std::sqrt(strayed_power_ / floor_power_);
    if (!(strayed > allowed)) return "";
    return formatted(
               "the floor turns, or its feet move each on their own: its signals differ by "
               "%.3g %% from a motion without that, and how it moves where no input measures it ",
               100 * strayed) +
           "is not known";
  }

  /// How far the floor is from one that does not turn, by what is left of its largest signal.
  void look_for_turns(const SampleBlock& block) {
    if (plan_.model->leans_on_rigid.empty()) return;
    const MatrixXd& w = block.floor_acceleration;
    const auto add = [&](const MatrixXd& signals, const MatrixXd& rigid) {
      if (signals.cols() == 0) return;
      strayed_power_ += (signals - rigid).colwise().squaredNorm().maxCoeff();
      floor_power_ += signals.colwise().squaredNorm().maxCoeff();
    };
    add(w, w * plan_.model->rigid.transpose());
    if (plan_.model->floors.size() > 0) {
      add(block.frame_acceleration(Eigen::all, floor_columns_),
          w * plan_.model->floors.transpose());
    }
  }

  void add_axes(const SampleBlock& block, const MatrixXd& by_floor, const MatrixXd& predicted,
                const MatrixXd& by_forces) {
    const MatrixXd floors = block.frame_acceleration(Eigen::all, floor_columns_);
    const MatrixXd frames = by_floor(Eigen::all, frame_columns_);
    const MatrixXd inputs = floors.leftCols(std::ssize(axis_signals().inputs));
    if (forces_axis_matrix_) {
      forces_axis_matrix_->add(block.first_seq, inputs, by_forces(Eigen::all, frame_columns_));
    }
    const bool about_model = model_ && !plan_.model->axes.empty();
    if (!about_model) return axis_matrix_->add(block.first_seq, inputs, frames);
    axis_matrix_->add(block.first_seq, inputs, frames, predicted.rightCols(frames.cols()),
                      floors - block.floor_acceleration * plan_.model->floors.transpose());
  }

  const ResponseSignals& axis_signals() const { return plan_.axis_signals.signals; }

  const std::function<AnalysisPlan(const run_info_t&)>& plan_of_;
  AnalysisPlan plan_;
  std::vector<Index> floor_columns_, frame_columns_;  ///< of the axes' signals
  run_info_t info_;
  double judged_from_s_ = 0;  ///< plant time
  FloorSamples floor_;
  std::vector<Axis> axes_;
  std::vector<Frame> frames_;
  std::vector<LegAnalyser> legs_;
  std::unique_ptr<ResponseAnalyser> matrix_, axis_matrix_, forces_matrix_, forces_axis_matrix_;
  DurationHistogram wake_up_, compute_;
  std::optional<FloorResponse> model_;
  std::optional<ForceResponse> forces_;
  std::int64_t n_explained_ = 0, n_judged_ = 0;
  double strayed_power_ = 0, floor_power_ = 0;  ///< (m/s^2)^2 times samples
  std::int64_t next_seq_ = 0, n_periods_ = 0, n_discarded_ = 0, n_commanded_ = 0;
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

#include "tools/run/study.hpp"

#include <algorithm>
#include <cmath>

#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/aim.hpp"
#include "judge/loop_between.hpp"
#include "judge/loop_design.hpp"
#include "judge/loop_target.hpp"
#include "judge/multisine_motion.hpp"
#include "judge/recorded_run.hpp"
#include "judge/verdict_of.hpp"
#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"
#include "plant_sim/run_length.hpp"
#include "report/analysis/summaries.hpp"
#include "report/verdict/acceptance.hpp"
#include "report/verdict/motion_level.hpp"
#include "tools/run/closed_loop.hpp"
#include "tools/run/run_files.hpp"

namespace stillframe::tools {

namespace {

/// What is compared, a row a sample: floor and frame of each.
struct Signals {
  Eigen::MatrixXd floor, frame;
};

/// Which of the recorded accelerations has this name; -1: none.
Index column_of(const Scene& scene, const std::string& name) {
  Index column = 0;
  for (const auto* signals : {&scene.outputs, &scene.monitors}) {
    for (const SceneSignal& signal : *signals) {
      if (signal.name == name) return column;
      ++column;
    }
  }
  return -1;
}

Block floor_block(const Scene& scene, const std::optional<std::filesystem::path>& file) {
  auto block = read_floor(scene, file);
  if (!block) {
    throw InputError(scene.file + ": the key 'floor' is missing, and no --floor is given");
  }
  return std::move(*block);
}

class StudyRun {
 public:
  StudyRun(const StudyCase& study, std::optional<double> duration_s)
      : design_(judge::make_loop_design(study.scene, study.controller)), spec_(floor_spec(study)) {
    controller::require_stable(design_.gains);
    multisine_ = judge::multisine_in(spec_);
    compared_ = judge::compared_frames(design_.scene, multisine_ ? &*multisine_ : nullptr);
    for (const judge::ComparedFrame& compared : compared_) {
      floor_columns_.push_back(column_of(design_.scene, compared.floor));
      frame_columns_.push_back(column_of(design_.scene, compared.frame));
    }
    const auto source = floor::make_floor_source(spec_);
    n_ = run_length(design_.scene, spec_, source->n_samples(), duration_s);
  }

  StudyResult run() {
    StudyResult result;
    result.n_samples = n_;
    const std::int64_t begin = monotonic_ns();
    const Signals passive = run_loop(false, result), active = run_loop(true, result);
    const double wall_s = 1e-9 * static_cast<double>(monotonic_ns() - begin);
    const double rate = design_.gains.sample_rate_hz;
    result.times_real_time = 2 * static_cast<double>(n_) / rate / wall_s;
    const SceneAcceptance accept = acceptance_of(design_.scene);
    report::Verdict& verdict = result.verdict;
    const std::vector<double> aimed = judge::aimed_hz(*design_.scene.controller);
    verdict.isolates_above_hz = 2 * *std::max_element(aimed.begin(), aimed.end());
    verdict.disturbed = judge::has_forces(design_.scene);
    const Eigen::MatrixXd by_forces = by_forces_of(verdict);
    verdict.floors_apart = multisine_ && multisine_->n_blocks > 1;
    verdict.judged = report::judged_range(judge::axis_of(design_));
    if (multisine_) verdict.judged = judge::with_lines(verdict.judged, *multisine_);
    for (size_t i = 0; i < floor_columns_.size(); ++i) {
      const auto c = static_cast<Index>(i);
      const auto floor = report::analyse_signal(passive.floor.col(c), rate),
                 below = report::analyse_signal(passive.frame.col(c), rate),
                 above = report::analyse_signal(active.frame.col(c), rate);
      std::optional<report::ForcesPart> forces;
      if (by_forces.cols() > c) {
        forces = {report::analyse_signal(by_forces.col(c), rate).power,
                  report::analyse_signal(active.frame.col(c) - by_forces.col(c), rate).power};
      }
      judge::add_levels(accept, compared_[i].name, floor_columns_[i] < 0 ? nullptr : &floor, &below,
                        &above, forces ? &*forces : nullptr, verdict);
    }
    verdict.judgement = report::judge(verdict, accept, {});
    return result;
  }

 private:
  floor::FloorSpec floor_spec(const StudyCase& study) const {
    return floor::read_floor_block(floor_block(design_.scene, study.floor).reader,
                                   design_.gains.sample_rate_hz, floor_input_names(design_.scene));
  }

  /// What the model makes of forces besides the floor, an axis a column; nothing if there are none.
  Eigen::MatrixXd by_forces_of(const report::Verdict& verdict) const {
    if (!verdict.disturbed || compared_.empty()) return {};
    std::vector<std::string> frames;
    for (const judge::ComparedFrame& compared : compared_) frames.push_back(compared.frame);
    return report::ForceResponse(judge::force_model(design_, frames, true)).at(0, n_);
  }

  Signals run_loop(bool active, StudyResult& result) {
    ClosedLoop loop(design_.scene, design_.gains, floor::make_floor_source(spec_), 1, active);
    result.method = method_name(loop.plant().choice().method);
    const auto n_axes = static_cast<Index>(floor_columns_.size());
    Signals signals{Eigen::MatrixXd(n_, n_axes), Eigen::MatrixXd(n_, n_axes)};
    double squares = 0;
    for (Index k = 0; k < n_; ++k) {
      const std::string reason = loop.step();
      if (!reason.empty()) throw std::runtime_error(reason);
      if (k % 1024 == 0 && stop_requested()) throw std::runtime_error("interrupted");
      const auto& read = loop.measurement();
      for (Index i = 0; i < n_axes; ++i) {
        const auto at = static_cast<size_t>(i);
        const auto column = [&](Index c) {
          return c < 0 ? 0 : read.frame_acceleration[static_cast<size_t>(c)];
        };
        signals.floor(k, i) = column(floor_columns_[at]);
        signals.frame(k, i) = column(frame_columns_[at]);
      }
      if (!active) continue;
      for (const double force : loop.command().force) {
        result.peak_force = std::max(result.peak_force, std::abs(force));
        squares += force * force;
      }
    }
    if (active) {
      const double count = static_cast<double>(n_) * static_cast<double>(design_.gains.n_legs());
      result.rms_force = std::sqrt(squares / count);
      if (loop.answer().n_fallback() > 0) {
        throw std::runtime_error(std::to_string(loop.answer().n_fallback()) +
                                 " commands fell back to zero force: values were not finite");
      }
    }
    result.verdict.runs.push_back({.scene_name = design_.scene.title,
                                   .scene_hash = design_.scene.hash,
                                   .program_version = STILLFRAME_VERSION,
                                   .mode = "single_process",
                                   .loop = active ? "active" : "passive",
                                   .sample_rate_hz = design_.gains.sample_rate_hz,
                                   .delay_samples = design_.gains.delay_samples,
                                   .n_samples = n_,
                                   .n_judged = n_,
                                   .n_commands = n_,
                                   .n_saturated = active ? loop.answer().n_saturated() : 0});
    return signals;
  }

  judge::LoopDesign design_;
  floor::FloorSpec spec_;
  std::optional<MultisinePlan> multisine_;
  std::vector<judge::ComparedFrame> compared_;
  std::vector<Index> floor_columns_, frame_columns_;
  std::int64_t n_ = 0;
};

}  // namespace

StudyResult run_case(const StudyCase& study, std::optional<double> duration_s) noexcept {
  StudyResult result;
  try {
    return StudyRun(study, duration_s).run();
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  return result;
}

StudyHashes hashes_of(const StudyCase& study) {
  const Scene scene = read_scene(study.scene, study.controller);
  if (!scene.controller) return {scene.hash, ""};  // said by who runs it
  const Block block = floor_block(scene, study.floor);
  const floor::FloorSpec spec = floor::read_floor_block(
      block.reader, scene.controller->sample_rate_hz, floor_input_names(scene));
  return {scene.hash, text_hash(block.text + RunFiles(scene, spec).hash())};
}

}  // namespace stillframe::tools

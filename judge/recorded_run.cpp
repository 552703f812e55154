#include "judge/recorded_run.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/yaml/load.hpp"
#include "judge/loop_between.hpp"
#include "judge/loop_target.hpp"
#include "judge/response_prediction.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::judge {

namespace {

/// The scene's text with a controller block of its own: the path that may stand there leads nowhere
/// from a log. What gains do not tell of it is not asked for.
std::string with_controller(const std::string& scene_text, const controller::Gains& gains,
                            const std::string& source_name) {
  // Written out: variables that only the blocks used which are left out here would be idle.
  YAML::Node scene = load_yaml(YamlReader::from_text(scene_text, source_name).dump(), source_name);
  YAML::Node block;
  block["legs"] = gains.legs;
  block["target_hz"] = 1;
  if (gains.target_hz.size() == 1) block["target_hz"] = gains.target_hz.front();
  if (gains.target_hz.size() > 1) block["target_hz"] = gains.target_hz;
  block["damping_ratio"] = 1;
  block["realisation"] = std::string(controller::to_text(gains.realisation));
  block["sample_rate_hz"] = gains.sample_rate_hz;
  block["delay_samples"] = gains.delay_samples;
  block["leak_hz"] = gains.leak_hz;
  scene["controller"] = block;
  scene.remove("floor");
  return YAML::Dump(scene);
}

/// The model of a run's loop and what it predicts of the plan's frequencies.
void add_model(report::AnalysisPlan& plan, const RecordedRun& run,
               const stillframe_msgs::run_info_t& info) {
  const LoopDesign& design = *run.design;
  const bool active = info.loop == "active";
  report::ResponseSignals all{
      info.floor_names, {info.frame_names.begin(), info.frame_names.begin() + plan.n_outputs}};
  plan.axis_signals = report::signals_by_name(plan.axes);
  const std::vector<std::string>& frames = plan.axis_signals.signals.outputs;
  all.outputs.insert(all.outputs.end(), frames.begin(), frames.end());
  const auto is_input = [](const std::string& name, const SceneSignal& input) {
    return name == input.name;
  };
  const auto& inputs = design.scene.inputs;
  if (!std::equal(all.inputs.begin(), all.inputs.end(), inputs.begin(), inputs.end(), is_input)) {
    plan.unmodelled = "the floor inputs of the log are not those of its scene";
    return;
  }
  std::vector<Eigen::MatrixXcd> predicted;
  try {
    FollowedFloor followed =
        followed_floor(design, all.outputs, active, run.nodes, plan.frequencies_hz, run.takeover());
    plan.model = report::RunModel{.loop = std::move(followed.loop),
                                  .late = std::move(followed.late),
                                  .matrix = {},
                                  .axes = {}};
    for (const double f : plan.frequencies_hz) {
      predicted.push_back(transfer(plan.model->loop, two_pi * f));
      plan.model->matrix.emplace_back(predicted.back().topRows(plan.n_outputs));
    }
    plan.model->rigid = std::move(followed.rigid);
    plan.model->moved_apart = run.nodes == FloorNodes::unknown;
    for (const Eigen::Index output : plan.axis_signals.output) {
      plan.model->leans_on_rigid.push_back(
          followed.leans_on_rigid[static_cast<std::size_t>(plan.n_outputs + output)]);
    }
  } catch (const std::exception& error) {
    plan.unmodelled = error.what();
    return;
  }
  try {
    report::AxisSignals axes = signals_by_motion(design.scene, plan.axes);
    std::vector<std::string> floors = axes.signals.inputs;
    floors.insert(floors.end(), axes.dependent_floors.begin(), axes.dependent_floors.end());
    plan.model->floors = floors_of_inputs(design.scene, floors);
    // Of the loop that is followed, on whatever floor it has: what the frame makes of other motion
    // is measured, and not taken off as if it had been followed.
    const Eigen::MatrixXd moved = inputs_of_floors(design.scene, axes.signals.inputs);
    for (const Eigen::MatrixXcd& T : predicted) {
      plan.model->axes.emplace_back(T.bottomRows(std::ssize(frames)) * moved);
    }
    plan.axis_signals = std::move(axes);
  } catch (const InputError&) {
    // The floors of the axes do not say how the floor moves; the verdict tells.
  }
}

}  // namespace

std::optional<MultisinePlan> multisine_in(const floor::FloorSpec& spec) {
  if (const auto* plan = std::get_if<MultisinePlan>(&spec.kind)) return *plan;
  if (const auto* sum = std::get_if<floor::SumSpec>(&spec.kind)) {
    for (const floor::FloorSpec& part : sum->parts) {
      if (auto plan = multisine_in(part)) return plan;
    }
  }
  return std::nullopt;
}

FrequencyRange with_lines(FrequencyRange range, const MultisinePlan& plan) {
  const std::vector<double>& lines = plan.frequencies_hz;
  const auto inside = [&](double f) { return f >= range.lowest_hz && f <= range.highest_hz; };
  if (lines.empty() || std::any_of(lines.begin(), lines.end(), inside)) return range;
  constexpr double beside = 1.1;  // so that an edge that is known to 1.5 % cuts no line
  return {std::min(range.lowest_hz, lines.front() / beside),
          std::max(range.highest_hz, lines.back() * beside)};
}

LoopDesign loop_design_of(const std::string& scene_text, const controller::Gains& gains,
                          const std::string& source_name) {
  LoopDesign design;
  try {
    design.scene = parse_scene(with_controller(scene_text, gains, source_name), source_name);
  } catch (const YAML::Exception& error) {
    throw InputError(source_name + ": the scene is no YAML: " + error.what());
  }
  design.scene.hash = gains.scene_hash;
  design.model = model_of(design.scene);
  design.loop.plant = loop_model(design.scene, design.model);
  design.loop.n_w = static_cast<Eigen::Index>(design.scene.inputs.size());
  design.loop.n_y = static_cast<Eigen::Index>(design.scene.outputs.size());
  design.loop.n_legs = gains.n_legs();
  design.loop.gains = gains.feedback();
  design.gains = gains;
  sample(design);
  return design;
}

RecordedRun recorded_run(const stillframe_msgs::run_info_t& info,
                         const std::filesystem::path& log) {
  const std::string source_name = log.string();
  RecordedRun run;
  try {
    const controller::Gains gains =
        controller::parse_gains(info.gains_text, source_name + ": gains_text");
    // No controller begins a run with gains of another scene.
    if (gains.scene_hash != info.scene_hash) {
      throw InputError(source_name + ": scene_hash: found " + info.scene_hash +
                       ", allowed is that of gains_text, " + gains.scene_hash +
                       ": the run was of the scene that its gains were designed for");
    }
    run.design = loop_design_of(info.scene_text, gains, source_name + ": scene_text");
  } catch (const std::exception& error) {
    run.unreadable = error.what();
  }
  try {
    // Under a rig the floor moves as it likes, and nobody says how.
    if (!info.floor_text.empty()) {
      const auto block = YamlReader::from_text(info.floor_text, source_name + ": floor_text");
      const floor::FloorSpec spec =
          floor::read_floor_block(block, info.sample_rate_hz, floor::FloorInputs(info.floor_names));
      run.multisine = multisine_in(spec);
      run.nodes = floor_nodes(spec);
    }
  } catch (const std::exception& error) {
    if (run.unreadable.empty()) run.unreadable = error.what();
  }
  try {
    run.hold = hold_of(log, info);
  } catch (const std::exception& error) {
    run.hold_unknown = error.what();
  }
  return run;
}

namespace {

/// Of the ranges in which verdict_of judges levels.
double lowest_judged_hz(const LoopDesign& design) {
  double lowest = report::judged_range(axis_of(design)).lowest_hz;
  for (const AxisAcceptance& asked : acceptance_of(design.scene).axes) {
    lowest = std::min(lowest, asked.from_hz);
  }
  return lowest;
}

/// Above 0.4 of the rate an estimate says little: a sensor's filter and folding are in it.
FrequencyRange shown(const RecordedRun& run, const stillframe_msgs::run_info_t& info) {
  FrequencyRange range =
      run.design ? axis_of(*run.design) : frequency_range({}, {}, info.sample_rate_hz);
  range.highest_hz = std::min(range.highest_hz, 0.4 * info.sample_rate_hz);
  range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  return range;
}

}  // namespace

report::AnalysisPlan analysis_plan(const RecordedRun& run,
                                   const stillframe_msgs::run_info_t& info) {
  report::AnalysisPlan plan;
  if (run.hold && run.hold->ever) {
    plan.judged_from = run.hold->from();
    plan.judged_until = run.hold->until;
  }
  plan.multisine = run.multisine;
  const FrequencyRange range = shown(run, info);
  const Eigen::VectorXd frequencies =
      logarithmic_frequencies(range.lowest_hz, range.highest_hz, 50);
  plan.frequencies_hz.assign(frequencies.begin(), frequencies.end());
  if (!run.design) {
    plan.unmodelled = run.unreadable;
    return plan;
  }
  const auto known = [&](const std::string& name) {
    return std::find(info.frame_names.begin(), info.frame_names.end(), name) !=
           info.frame_names.end();
  };
  for (const SceneComparison& comparison : run.design->scene.comparisons) {
    if (!known(comparison.floor) || !known(comparison.frame)) continue;
    // Multisines move the floor inputs, each on its own: no floor goes with that.
    if (run.multisine) {
      plan.frames.insert(plan.frames.end(), {comparison.floor, comparison.frame});
    } else {
      plan.axes.push_back({comparison.name, comparison.floor, comparison.frame});
    }
  }
  const auto& sensors = run.design->scene.instruments.floor_sensors;
  if (sensors) plan.floor_noise = sensors->noise;
  plan.lowest_hz = lowest_judged_hz(*run.design);
  plan.n_outputs = std::min<Eigen::Index>(run.design->loop.n_y, info.n_frame);
  if (run.multisine) {
    plan.lowest_hz =
        std::min(plan.lowest_hz,
                 with_lines(report::judged_range(axis_of(*run.design)), *run.multisine).lowest_hz);
    plan.frames.insert(plan.frames.end(), info.frame_names.begin(),
                       info.frame_names.begin() + plan.n_outputs);
    std::sort(plan.frames.begin(), plan.frames.end());
    plan.frames.erase(std::unique(plan.frames.begin(), plan.frames.end()), plan.frames.end());
  }
  if (has_forces(run.design->scene)) {
    try {
      if (!run.hold_unknown.empty()) throw InputError(run.hold_unknown);
      plan.forces =
          force_model(*run.design, info.frame_names, info.loop == "active", run.takeover());
    } catch (const std::exception& error) {
      plan.forces_unknown = error.what();
    }
  }
  if (!run.multisine) add_model(plan, run, info);
  return plan;
}

}  // namespace stillframe::judge

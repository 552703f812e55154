#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "judge/floor_nodes.hpp"
#include "judge/loop_design.hpp"
#include "report/analysis/loop_response.hpp"

namespace stillframe::judge {

/// The sampled plant of a design from accelerations and forces to outputs and monitors of its scene
/// by name. Errors: InputError for a name that the scene has not.
SampledPlant plant_between(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                           const std::vector<std::string>& outputs);

/// The disturbances of a scene as inputs (N), in their order.
std::vector<SceneSignal> force_signals(const Scene& scene);

/// The sampled loop of a design, with its law or with zero commands, from inputs of one's own
/// (accelerations and forces, of which a feed-forward hears nothing) to outputs and monitors of its
/// scene by name. Errors: InputError for a name that the scene has not.
SampledLoop loop_between(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                         const std::vector<std::string>& outputs, bool active);

/// A loop from its scene's inputs that also knows what floor nodes do where these do not measure
/// them.
struct FollowedFloor {
  /// All prescribed translations across the inputs of their node go with a floor that does not turn
  /// and moves as the inputs say, a = D_w^+ w, or rest.
  SampledLoop loop;
  std::optional<report::LateLoop>
      late;  ///< the same, of one that was not closed from the beginning
  /// D_w D_w^+: what the inputs would be on such a floor.
  Eigen::MatrixXd rigid;
  /// Of the outputs: more than a thousandth of them may come of nodes that no input measures, and
  /// that do not rest.
  std::vector<bool> leans_on_rigid;
};

/// nodes: unless they rest the loop has them follow. frequencies_hz: at which outputs are weighed.
/// takeover: of an active loop that was not closed from the beginning on. Errors: as loop_between.
FollowedFloor followed_floor(const LoopDesign& design, const std::vector<std::string>& outputs,
                             bool active, FloorNodes nodes,
                             const std::vector<double>& frequencies_hz,
                             const std::optional<report::Takeover>& takeover = {});

/// Whether a scene has a disturbance that is not zero at all times.
bool has_forces(const Scene& scene);

/// What a scene's disturbances do to outputs and monitors by name. takeover: as above. Errors: as
/// loop_between and ForceCourse.
report::ForceModel force_model(const LoopDesign& design, const std::vector<std::string>& outputs,
                               bool active, const std::optional<report::Takeover>& takeover = {});

}  // namespace stillframe::judge

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/scene_design.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor_motion.hpp"

namespace stillframe::random_scenes {

struct Answers;

/// A scene with what is computed of it, once each and only when asked for. Errors of all: as the
/// functions that compute it.
class Case {
 public:
  /// Errors: InputError.
  explicit Case(std::string text, const std::string& name = "random_scene")
      : text_(std::move(text)), name_(name), scene_(parse_scene(text_, name)) {}

  const std::string& text() const { return text_; }
  const std::string& name() const { return name_; }
  const Scene& scene() const { return scene_; }
  const Model& model() {
    if (!model_) model_ = make_model(scene_);
    return *model_;
  }
  const NominalMotion& operating_point() {
    if (!nominal_) nominal_ = nominal_motion(model());
    return *nominal_;
  }
  /// With the scene's own inputs and outputs.
  const LinearModel& linear() {
    if (!linear_) linear_ = linearise(model(), scene_.inputs, scene_.outputs);
    return *linear_;
  }
  bool at_rest() { return !operating_point().moving(); }
  bool has_loop() const { return scene_.controller.has_value(); }
  /// How the floor moves, if the scene says so, for a run at the scene's rate.
  const std::optional<floor::FloorSpec>& floor() {
    if (!floor_ && has_loop()) {
      const auto block = YamlReader::from_text(text_, name_).find("floor");
      if (block) {
        floor_ = floor::read_floor_block(*block, scene_.controller->sample_rate_hz,
                                         floor_input_names(scene_));
      }
    }
    return floor_;
  }
  const judge::LoopDesign& design() {
    if (!design_) design_ = judge::make_loop_design(scene_);
    return *design_;
  }

  std::shared_ptr<const Answers> answers;  ///< of own_answers()
  bool in_full = false;  ///< whatever it takes: nothing is left out because it is dear

 private:
  std::string text_, name_;
  Scene scene_;
  std::optional<Model> model_;
  std::optional<NominalMotion> nominal_;
  std::optional<LinearModel> linear_;
  std::optional<floor::FloorSpec> floor_;
  std::optional<judge::LoopDesign> design_;
};

}  // namespace stillframe::random_scenes

#include "core/mechanics/sparse/sparse_scene.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"

namespace stillframe {

namespace {

bool rests(const Model& model) { return model.q_r_dot_0.isZero(0) && model.q_r_ddot_0.isZero(0); }

}  // namespace

std::optional<Model> large_scene(const Scene& scene, Eigen::Index n_asked, Eigen::Index fewest) {
  if (!scene.automatic_dofs || scene.operating_point != OperatingPoint::equilibrium) return {};
  if (scene.modal_damping) return {};  // it couples everything with everything
  Model model = free_model(scene);
  if (!rests(model) || !model.turning_loads.empty()) return {};
  // A Krylov space is still a small part.
  if (model.n_c < fewest || 4 * n_asked > model.n_c) return {};
  return model;
}

ReducedModel reduced_model(const Scene& scene, const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs) {
  const std::string& place = scene.reduction.value().place;
  const auto refuse = [&](const std::string& why) {
    return InputError(place + ": " + why + "; a reduced model stands about a position at rest");
  };
  if (scene.operating_point != OperatingPoint::equilibrium) {
    throw refuse("the scene asks for a snapshot (operating_point: as_written)");
  }
  const Model model = free_model(scene);
  if (!rests(model)) throw refuse("a prescribed motion of the scene does not rest");
  if (!model.turning_loads.empty()) {
    throw refuse("a load of the scene turns with its node, and its stiffness is not symmetric");
  }
  const MixedModel mixed(model);
  return reduced_model(mixed, sparse_equilibrium(mixed).state, inputs, outputs, *scene.reduction);
}

}  // namespace stillframe

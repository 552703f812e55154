#include "core/mechanics/sparse/sparse_scene.hpp"

#include "core/mechanics/partition/free_model.hpp"

namespace stillframe {

std::optional<Model> large_scene(const Scene& scene, Eigen::Index n_asked) {
  if (!scene.automatic_dofs || scene.operating_point != OperatingPoint::equilibrium) return {};
  Model model = free_model(scene);
  const bool rests = model.q_r_dot_0.isZero(0) && model.q_r_ddot_0.isZero(0);
  if (!rests || !model.turning_loads.empty()) return {};
  // Where both take the same time (docs/growth.md), and a Krylov space is still a small part.
  constexpr Eigen::Index few = 200;
  if (model.n_c < few || 4 * n_asked > model.n_c) return {};
  return model;
}

}  // namespace stillframe

#pragma once

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// The scene's operating point: its equilibrium or stationary motion, or the snapshot that it asks
/// for with operating_point: as_written, the motion as written with q''^d from the equations of
/// motion. Errors: as solve_equilibrium; Refusal if the motion as written cannot be reached or
/// accelerates a dof without mass.
NominalMotion nominal_motion(const Model& model);

/// Linearises about the scene's operating point. Errors: as nominal_motion and Lineariser; Refusal
/// naming the signal if the operating point is stationary but not as the inputs and outputs see it,
/// and the scene asks for no snapshot.
LinearModel linearise(const Model& model, const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs);

/// The model of a scene that is linearised: make_model(scene), or, where it says `reduce`,
/// free_model(scene), of which nobody chooses dofs. Errors: likewise.
Model model_of(const Scene& scene);

/// The same of model = model_of(scene), on the lowest modes where the scene says `reduce`.
/// Errors: those too of reduced_model (core/mechanics/sparse/sparse_scene.hpp).
LinearModel linearise(const Scene& scene, const Model& model,
                      const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs);

}  // namespace stillframe

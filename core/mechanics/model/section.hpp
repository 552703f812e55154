#pragma once

#include "core/mechanics/elements/element.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// Phi = 12 EI / (k G A l_0^2) of bending along n_y (about n_z) and along n_z (about n_y), 0 where
/// it is not flexible in shear.
double shear_ratio_y(const SceneBeam& section, double l_0);
double shear_ratio_z(const SceneBeam& section, double l_0);

/// Stiffness S of a beam of constant section and length l_0 (m), dual to the deformations of Beam
/// (6 x 6, N/m):
///   diag(EA / l_0, GJ / l_0^3) and for each bending pair
///   EI / ((1 + Phi) l_0^3) [4 + Phi, Phi - 2; Phi - 2, 4 + Phi].
/// planar: that of PlanarBeam (3 x 3).
LocalStiffness section_stiffness(const SceneBeam& section, double l_0, bool planar);

}  // namespace stillframe

#pragma once

#include "core/mechanics/linearisation/linearisation.hpp"

// A motion is stationary if it can go on for ever with constant rates (q''^d and q''^r constant) as
// a motion about which the linear model is one and the same: the balance of forces and all
// matrices, those of the inputs and outputs included, do not change with time. So a table that
// turns about a fixed axle is, with coordinates that turn with it; an arm that turns under gravity
// is not.
namespace stillframe {

/// q'^d and q''^d (n_d each) that go along with the prescribed motion: with constant matrices,
/// derivatives of the balance in time,
///   (K + N + G) q''^d + (K_r + N_r + G_r) q''^r = 0,
///   (K + N + G) q'^d + (C + D) q''^d + (K_r + N_r + G_r) q'^r + (C_r + D_r) q''^r = 0.
/// Zero where q^d moves with the prescribed motion, as deformations do.
struct Rates {
  Eigen::VectorXd velocity, acceleration;
};
Rates rates_along(const Model& model, const NominalMotion& nominal);

/// Takes the motion on by finite times, parts of a turn or of the scene's size that have no common
/// measure, and compares. Does nothing, at no cost, where no prescribed coordinate has a rate or an
/// acceleration. Errors: Refusal naming the prescribed motion and what does not stay the same: the
/// balance, the matrices, or an input or output.
void require_stationary(const Model& model, const NominalMotion& nominal,
                        const std::vector<SceneSignal>& inputs,
                        const std::vector<SceneSignal>& outputs);

}  // namespace stillframe

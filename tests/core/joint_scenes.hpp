#pragma once

#include "core/mechanics/scene/scene.hpp"

// Mechanisms of hinges and rigid links, with the closed forms of their motion in the tests that use
// them.
namespace stillframe::test {

/// A spatial chain of rigid links on hinges about oblique axes: base, then `links` links from
/// "joint_1" on, with nodes "start_i" and "end_i" and hinges "hinge_i". q^d: the angles of the
/// hinges, but for the first, whose angle is prescribed if `drive_first`.
Scene hinge_chain(int links, bool drive_first);
/// Axis of hinge i and link i of the chain as written, i from 1.
Eigen::Vector3d chain_axis(int i);
Eigen::Vector3d chain_link(int i);

/// Two bodies without length on hinges about chain_axis(1) and chain_axis(2): a rotor "start_1",
/// whose angle is prescribed, and a disc "start_2" on it. q^d: the angle of the disc.
Scene spinning_rotor();

/// Planar crank (0.3 m), rod (0.8 m) and slider on the x axis, as written at a crank angle of 0.5
/// rad. q^d: the angle of the crank.
Scene slider_crank();
/// Planar four-bar linkage between the bases (0, 0) and (1, 0.1), q^d: the angle of the crank. The
/// hinges close a loop of shared translations.
Scene four_bar();

}  // namespace stillframe::test

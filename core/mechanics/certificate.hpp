#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// How far one block of a linear model is from the derivatives of the nonlinear equations.
struct BlockCertificate {
  std::string block;      ///< "M", "C", "D", "K", "N", "G", or "A", "B", "C_y", "D_y"
  double difference = 0;  ///< largest difference, relative to the largest entry of its kind
  double known_to = 0;    ///< the rounding of the differences, relative to the same
  double size = 0;        ///< largest entry of the block; 0: the block is zero on both sides
};

/// Linearises the scene about its operating point and compares every block with extrapolated
/// differences of the nonlinear equations.
///   M = d/dq'' of DF^T f_I, C = d/dq' of it, D = d/dq' of DF_e^T S_d e', K = d/dq of DF_e^T S e,
///   N = d/dq of DF^T f_I + DF_e^T S_d e' (DF, DF_e held), G = d/dq of DF^T (f_I - f) + DF_e^T
///   sigma (f_I and sigma held),
/// each for the dofs and for the prescribed motions among the inputs; A, B from the accelerations
/// of the equations of motion as they are simulated, C_y and D_y (the deck's C and D) from the
/// outputs. The second-order blocks are judged by their largest entry, rows of A and B by the
/// largest of the accelerations, each output by its own largest entry. progress hears the share
/// that is done, 0 to 1. Errors: as linearise.
std::vector<BlockCertificate> certify(
    const Scene& scene, const std::function<void(double)>& progress = [](double) {});

/// What a certificate has to reach: differences of smooth functions do, by two or more decades.
inline constexpr double certified_difference = 1e-9;

/// Whether it does, or comes as near as the rounding of a light part on a very stiff one lets the
/// differences be known, which has to be 1e-5 at least.
inline bool is_certified(const BlockCertificate& block) {
  return block.difference <= std::max(certified_difference, std::min(block.known_to, 1e-5));
}

}  // namespace stillframe

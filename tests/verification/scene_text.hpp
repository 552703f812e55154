#pragma once

#include <Eigen/Core>
#include <string>

#include "core/mechanics/linearisation/linearisation.hpp"

// The scenes of config/scenes, changed as text before they are read: what a user would edit.
namespace stillframe::verification {

/// The text of config/scenes/NAME.yaml.
std::string scene_text(const std::string& name);
/// The text with every `from` replaced. Errors: std::runtime_error if it is not there.
std::string with(std::string text, const std::string& from, const std::string& to);
/// The text with n in every `divide: N`.
std::string divided(const std::string& text, int n);
/// The text without second-order terms in its beams.
std::string first_order(const std::string& text);
/// The text without its inputs and outputs, which may name nodes of a divided beam.
std::string without_signals(const std::string& text);
/// rotating_cantilever.yaml with a blade that does not twist and has no inertia about its axis,
/// which lowers the frequencies of the scene by 1e-6: the problem of the tables.
std::string blade_without_twist();
/// A number as it is written into a scene, to the last digit.
std::string number(double value);

/// A scene about its operating point.
LinearModel linear_model(const std::string& text);
/// Natural frequencies, Hz, of a scene at rest.
Eigen::VectorXd frequencies_hz(const std::string& text);
/// Buckling multipliers of a scene, smallest first.
Eigen::VectorXd multipliers(const std::string& text);

}  // namespace stillframe::verification

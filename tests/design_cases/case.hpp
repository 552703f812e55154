#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/control/design/control_loop.hpp"
#include "core/control/loop_settings.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::test {

/// A scene of config/scenes with a controller of config/controllers, or its own; no force limit, as
/// saturation is no part of a prediction.
Scene case_scene(const std::string& name, const std::string& controller = "");

/// A loop and what the analysis says of it.
struct Case {
  Scene scene;
  Model model;
  ControlLoop loop;
  LoopSettings settings;
  SampledLoop closed;
  double radius = 0;

  bool stable() const { return radius < largest_stable_radius; }
  /// Largest real part of the poles of the continuous loop, 1/s.
  double continuous_growth() const;
  /// Singular values of the T that a log must show, largest first, 1. hz: Hz.
  Eigen::VectorXd predicted(double hz) const;
  /// Largest singular value of T, dB.
  double predicted_db(double hz) const;
};

/// With a design scene, the gains are those of its model under the controller of `scene`.
Case make_case(const Scene& scene, const std::optional<Scene>& design_scene = {});

/// The pole of the sampled loop that is largest in modulus, as one of continuous time: growth in
/// 1/s and frequency in Hz, up to half the rate.
struct DecidingPole {
  double growth = 0, hz = 0;
};
DecidingPole deciding_pole(const Case& made);

/// A line of the tables of docs/design_cases.md: radius, disk margin and T of a case.
void print_line(const std::string& setting, const Case& made);

}  // namespace stillframe::test

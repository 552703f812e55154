#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

// A scene of rigid bodies as any multibody program can be told it, and what a run of it gives.
// C++17, as Simbody's headers want it.
namespace stillframe::race {

/// Where a point is: on a body, or at rest on the base (body -1).
struct Point {
  int body = -1;
  Eigen::Vector3d position;  ///< m, of the scene as written
};

struct RigidBody {
  std::string joint;  ///< "pin" on the parent, or "free"
  int parent = -1;
  Eigen::Vector3d hinge, axis;  ///< m, of a pin
  double stiffness = 0, damping = 0;
  double mass = 0;
  Eigen::Vector3d centre;
  Eigen::Matrix3d J;  ///< kg m^2, about the centre of mass
};

/// Between two points; input: the one that moves the first of them, along a direction, or -1.
struct Spring {
  Point from, to;
  double stiffness = 0, damping = 0;
  int input = -1;
  Eigen::Vector3d direction;
};

/// A point of a body that stays in the plane through it as written.
struct PlaneGuide {
  Point point;
  Eigen::Vector3d normal;
};

struct Output {
  Point point;
  Eigen::Vector3d direction;
};

/// At rest as written.
struct Mechanism {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double sample_time = 0;
  std::vector<RigidBody> bodies;
  std::vector<Spring> springs;
  std::vector<PlaneGuide> guides;
  std::vector<Output> outputs;
  /// Directions along which the inputs move the base, or zero: they move springs.
  std::vector<Eigen::Vector3d> base_inputs;
};

struct Run {
  Eigen::MatrixXd accelerations;  ///< outputs x samples, m/s^2: means over each sample
  double seconds = 0;             ///< processor time of the samples, without set-up

  /// Of the outputs at the end (m/s).
  Eigen::VectorXd last_velocities(double sample_time) const {
    return sample_time * accelerations.rowwise().sum();
  }
};

std::string to_text(const Mechanism& mechanism);
/// Errors: nlohmann::json::exception.
Mechanism from_text(const std::string& text);

/// Reproducible inputs: a sum of sines along each, m/s^2.
Eigen::MatrixXd sines(Eigen::Index inputs, Eigen::Index samples, double sample_time,
                      double amplitude, double lowest_hz, double highest_hz);

/// In Simbody: pins and a free body with quaternions. A base that moves is gravity that changes
/// from sample to sample. inputs: inputs x samples, m/s^2, held over each sample. method: "Merson"
/// or "Feldberg". Errors: std::invalid_argument.
Run simbody_run(const Mechanism& mechanism, const Eigen::MatrixXd& inputs,
                const std::string& method, double accuracy);

}  // namespace stillframe::race

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

// The same runs in two programs: output accelerations, means over each sample, for given
// accelerations of the floor (inputs x samples, m/s^2) held over each sample. C++17, as Simbody's
// headers want it.
namespace stillframe::simbody {

struct Run {
  Eigen::MatrixXd accelerations;  ///< outputs x samples, m/s^2
  double seconds = 0;             ///< wall time of the samples, without set-up
};

struct MassProperties {
  double mass = 0;    ///< kg
  Eigen::Matrix3d J;  ///< kg m^2, about the centre of mass
};

/// A point whose acceleration along a direction is an output.
struct Output {
  size_t body = 0;
  Eigen::Vector3d point, direction;  ///< m, of the scene as written
};

/// One rigid body on springs whose feet are moved along one direction each: input i moves foot i.
struct BodyOnSprings {
  struct Spring {
    Eigen::Vector3d top, foot, direction;
    double stiffness = 0;  ///< N/m
  };
  MassProperties body;
  Eigen::Vector3d centre;
  std::vector<Spring> springs;
  std::vector<Output> outputs;
  double sample_time = 0;
};

/// Rigid links in a row, each on a hinge at the end of the last; the inputs move the first hinge
/// along x, y and z.
struct LinkChain {
  struct Link {
    MassProperties end;
    Eigen::Vector3d hinge, axis, centre;  ///< m, of the scene as written; centre of mass at the end
  };
  std::vector<Link> links;
  Eigen::Vector3d gravity;
  std::vector<Output> outputs;
  double sample_time = 0;
};

enum class Method { runge_kutta_merson, runge_kutta_feldberg };
std::string name_of(Method method);

/// In Simbody: a free body with quaternions, and forces of springs between moving points.
Run simbody_run(const BodyOnSprings& scene, const Eigen::MatrixXd& floor, Method method,
                double accuracy);
/// In Simbody: pins in axes that the base carries along, in which gravity changes from sample to
/// sample.
Run simbody_run(const LinkChain& scene, const Eigen::MatrixXd& floor, Method method,
                double accuracy);

/// Reproducible floors: a sum of sines along each input, m/s^2.
Eigen::MatrixXd sines(Eigen::Index inputs, Eigen::Index samples, double sample_time,
                      double amplitude, double lowest_hz, double highest_hz);

/// Relative difference of two runs, by the root mean square of all entries.
double difference(const Run& a, const Run& b);

}  // namespace stillframe::simbody

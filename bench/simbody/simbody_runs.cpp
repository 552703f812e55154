// The runs in Simbody. Nothing here uses the multibody core.
#include <Simbody.h>

#include <chrono>
#include <functional>
#include <memory>

#include "bench/simbody/held_floor.hpp"
#include "bench/simbody/runs.hpp"

namespace stillframe::simbody {

namespace {

using SimTK::Vec3;

Vec3 vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

SimTK::Inertia inertia_of(const Eigen::Matrix3d& J) {
  return {J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)};
}

std::unique_ptr<SimTK::Integrator> make_integrator(const SimTK::System& system, Method method,
                                                   double accuracy) {
  std::unique_ptr<SimTK::Integrator> integrator;
  switch (method) {
    case Method::runge_kutta_merson:
      integrator = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
      break;
    case Method::runge_kutta_feldberg:
      integrator = std::make_unique<SimTK::RungeKuttaFeldbergIntegrator>(system);
      break;
  }
  integrator->setAccuracy(accuracy);
  integrator->setAllowInterpolation(false);
  return integrator;
}

/// Steps through all samples and stops at each, where the inputs change. velocities: of the outputs
/// in a state, at the end of the present sample; change: what the next sample does to the state.
Run run(const SimTK::System& system, const SimTK::State& start, HeldFloor& floor, Method method,
        double accuracy, const std::function<Eigen::VectorXd(const SimTK::State&)>& velocities,
        const std::function<void(SimTK::State&)>& change) {
  const auto integrator = make_integrator(system, method, accuracy);
  Run result;
  SimTK::State state = start;
  change(state);
  system.realize(state, SimTK::Stage::Acceleration);
  Eigen::VectorXd before = velocities(state);
  before.setZero();
  result.accelerations.resize(before.size(), floor.samples());
  integrator->initialize(state);
  const auto begin = std::chrono::steady_clock::now();
  for (Eigen::Index k = 0; k < floor.samples(); ++k) {
    const double end = static_cast<double>(k + 1) * floor.sample_time();
    integrator->stepTo(end, end);
    while (integrator->getState().getTime() < end) integrator->stepTo(end, end);
    system.realize(integrator->getState(), SimTK::Stage::Velocity);
    const Eigen::VectorXd now = velocities(integrator->getState());
    result.accelerations.col(k) = (now - before) / floor.sample_time();
    before = now;
    if (k + 1 == floor.samples()) break;
    floor.next();
    SimTK::State& advanced = integrator->updAdvancedState();
    change(advanced);
    advanced.invalidateAllCacheAtOrAbove(SimTK::Stage::Dynamics);
    integrator->reinitialize(SimTK::Stage::Position, false);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

/// Springs from points of one body to points of the floor that move.
class ShakenSprings : public SimTK::Force::Custom::Implementation {
 public:
  ShakenSprings(const SimTK::MobilizedBody& body, const BodyOnSprings& scene,
                const HeldFloor& floor)
      : body_(body), floor_(floor) {
    for (const BodyOnSprings::Spring& spring : scene.springs) {
      springs_.push_back({vec(spring.top - scene.centre), vec(spring.foot), vec(spring.direction),
                          spring.stiffness, (spring.top - spring.foot).norm()});
    }
  }

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                 SimTK::Vector_<Vec3>&, SimTK::Vector&) const override {
    const double t = state.getTime();
    for (size_t i = 0; i < springs_.size(); ++i) {
      const Spring& spring = springs_[i];
      const Vec3 foot =
          spring.foot + floor_.position(static_cast<Eigen::Index>(i), t) * spring.direction;
      const Vec3 span = body_.findStationLocationInGround(state, spring.station) - foot;
      const double length = span.norm();
      const Vec3 force = -spring.stiffness * (length - spring.length) / length * span;
      body_.applyForceToBodyPoint(state, spring.station, force, forces);
    }
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }

 private:
  struct Spring {
    Vec3 station, foot, direction;
    double stiffness, length;
  };
  SimTK::MobilizedBody body_;
  const HeldFloor& floor_;
  std::vector<Spring> springs_;
};

}  // namespace

std::string name_of(Method method) {
  return method == Method::runge_kutta_merson ? "Simbody, Runge-Kutta-Merson"
                                              : "Simbody, Runge-Kutta-Feldberg";
}

Run simbody_run(const BodyOnSprings& scene, const Eigen::MatrixXd& accelerations, Method method,
                double accuracy) {
  HeldFloor floor(accelerations, scene.sample_time);
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter(system);
  SimTK::GeneralForceSubsystem forces(system);
  const SimTK::Body::Rigid rigid(
      SimTK::MassProperties(scene.body.mass, Vec3(0), inertia_of(scene.body.J)));
  SimTK::MobilizedBody::Free body(matter.Ground(), SimTK::Transform(vec(scene.centre)), rigid,
                                  SimTK::Transform());
  // Simbody owns what a force is given.
  SimTK::Force::Custom force(forces, new ShakenSprings(body, scene, floor));
  const SimTK::State start = system.realizeTopology();
  const auto velocities = [&](const SimTK::State& state) {
    Eigen::VectorXd v(static_cast<Eigen::Index>(scene.outputs.size()));
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const Output& output = scene.outputs[static_cast<size_t>(i)];
      const Vec3 station = vec(output.point - scene.centre);
      v(i) = SimTK::dot(body.findStationVelocityInGround(state, station), vec(output.direction));
    }
    return v;
  };
  return run(system, start, floor, method, accuracy, velocities, [](SimTK::State&) {});
}

Run simbody_run(const LinkChain& scene, const Eigen::MatrixXd& accelerations, Method method,
                double accuracy) {
  HeldFloor floor(accelerations, scene.sample_time);
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter(system);
  SimTK::GeneralForceSubsystem forces(system);
  SimTK::Force::Gravity gravity(forces, matter, vec(scene.gravity));
  SimTK::MobilizedBody parent = matter.Ground();
  Eigen::Vector3d parent_hinge = Eigen::Vector3d::Zero();
  std::vector<SimTK::MobilizedBody> bodies;
  for (const LinkChain::Link& link : scene.links) {
    const Vec3 arm = vec(link.centre - link.hinge);
    const SimTK::Body::Rigid rigid(SimTK::MassProperties(
        link.end.mass, arm, inertia_of(link.end.J).shiftFromMassCenter(arm, link.end.mass)));
    const SimTK::Rotation axes(SimTK::UnitVec3(vec(link.axis)), SimTK::ZAxis);
    bodies.push_back(
        SimTK::MobilizedBody::Pin(parent, SimTK::Transform(axes, vec(link.hinge - parent_hinge)),
                                  rigid, SimTK::Transform(axes)));
    parent = bodies.back();
    parent_hinge = link.hinge;
  }
  const SimTK::State start = system.realizeTopology();
  const auto velocities = [&](const SimTK::State& state) {
    Eigen::VectorXd v(static_cast<Eigen::Index>(scene.outputs.size()));
    const Vec3 base = vec(floor.rate_at_end());
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const Output& output = scene.outputs[static_cast<size_t>(i)];
      const Vec3 station = vec(output.point - scene.links[output.body].hinge);
      v(i) = SimTK::dot(bodies[output.body].findStationVelocityInGround(state, station) + base,
                        vec(output.direction));
    }
    return v;
  };
  const auto change = [&](SimTK::State& state) {
    gravity.setGravityVector(state, vec(scene.gravity - floor.acceleration()));
  };
  return run(system, start, floor, method, accuracy, velocities, change);
}

}  // namespace stillframe::simbody

// The runs in Simbody. Nothing here uses the multibody core.
#include <Simbody.h>

#include <ctime>
#include <memory>
#include <stdexcept>

#include "bench/large_motion/held_floor.hpp"
#include "bench/large_motion/mechanism.hpp"

namespace stillframe::race {

namespace {

using SimTK::Vec3;

Vec3 vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

SimTK::Inertia inertia_of(const Eigen::Matrix3d& J) {
  return {J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2)};
}

std::unique_ptr<SimTK::Integrator> make_integrator(const SimTK::System& system,
                                                   const std::string& method, double accuracy) {
  std::unique_ptr<SimTK::Integrator> integrator;
  if (method == "Merson") {
    integrator = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
  } else if (method == "Feldberg") {
    integrator = std::make_unique<SimTK::RungeKuttaFeldbergIntegrator>(system);
  } else {
    throw std::invalid_argument("no method " + method);
  }
  integrator->setAccuracy(accuracy);
  integrator->setAllowInterpolation(false);
  return integrator;
}

/// A spring and damper from points of the floor that move to a body.
class ShakenSpring : public SimTK::Force::Custom::Implementation {
 public:
  ShakenSpring(const SimTK::MobilizedBody& body, Vec3 station, const Spring& spring,
               const HeldFloor& floor)
      : body_(body), station_(station), spring_(spring), floor_(floor) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                 SimTK::Vector_<Vec3>&, SimTK::Vector&) const override {
    const Vec3 foot = vec(spring_.from.position) +
                      floor_.position(spring_.input, state.getTime()) * vec(spring_.direction);
    const Vec3 span = body_.findStationLocationInGround(state, station_) - foot;
    const double length = span.norm(), rest = (spring_.to.position - spring_.from.position).norm();
    const Vec3 force = -spring_.stiffness * (length - rest) / length * span;
    body_.applyForceToBodyPoint(state, station_, force, forces);
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }

 private:
  SimTK::MobilizedBody body_;
  Vec3 station_;
  Spring spring_;
  const HeldFloor& floor_;
};

/// A mechanism as Simbody has it.
class System {
 public:
  System(const Mechanism& mechanism, const HeldFloor& floor)
      : mechanism_(mechanism),
        floor_(floor),
        matter_(system_),
        forces_(system_),
        gravity_(forces_, matter_, vec(mechanism.gravity)) {
    for (const RigidBody& body : mechanism.bodies) add(body);
    for (const Spring& spring : mechanism.springs) add(spring);
    for (const PlaneGuide& guide : mechanism.guides) {
      const SimTK::UnitVec3 normal(vec(guide.normal));
      SimTK::MobilizedBody held = body(guide.point);
      SimTK::Constraint::PointInPlane(matter_.updGround(), normal,
                                      SimTK::dot(normal, vec(guide.point.position)), held,
                                      station(guide.point));
    }
  }

  const SimTK::MultibodySystem& system() const { return system_; }
  SimTK::State start() { return system_.realizeTopology(); }

  /// Velocities of the outputs at the end of the present sample.
  Eigen::VectorXd velocities(const SimTK::State& state) const {
    Eigen::VectorXd v(static_cast<Eigen::Index>(mechanism_.outputs.size()));
    const Eigen::VectorXd rates = floor_.rate_at_end();
    Eigen::Vector3d base = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < mechanism_.base_inputs.size(); ++i) {
      base += rates(static_cast<Eigen::Index>(i)) * mechanism_.base_inputs[i];
    }
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      const Output& output = mechanism_.outputs[static_cast<std::size_t>(i)];
      const Vec3 velocity =
          body(output.point).findStationVelocityInGround(state, station(output.point));
      v(i) = SimTK::dot(velocity + vec(base), vec(output.direction));
    }
    return v;
  }
  /// What the inputs of the present sample do to a state.
  void change(SimTK::State& state) const {
    Eigen::Vector3d g = mechanism_.gravity;
    const Eigen::VectorXd a = floor_.acceleration();
    for (std::size_t i = 0; i < mechanism_.base_inputs.size(); ++i) {
      g -= a(static_cast<Eigen::Index>(i)) * mechanism_.base_inputs[i];
    }
    gravity_.setGravityVector(state, vec(g));
  }

 private:
  SimTK::MobilizedBody body(const Point& point) const {
    return point.body < 0 ? SimTK::MobilizedBody(matter_.getGround())
                          : bodies_[static_cast<std::size_t>(point.body)];
  }
  /// Where a body's own axes begin: at its hinge, or at its centre of mass.
  Eigen::Vector3d origin(int index) const {
    if (index < 0) return Eigen::Vector3d::Zero();
    const RigidBody& body = mechanism_.bodies[static_cast<std::size_t>(index)];
    return body.joint == "pin" ? body.hinge : body.centre;
  }
  Vec3 station(const Point& point) const { return vec(point.position - origin(point.body)); }

  void add(const RigidBody& item) {
    if (item.joint == "free") {
      const SimTK::Body::Rigid rigid(SimTK::MassProperties(item.mass, Vec3(0), inertia_of(item.J)));
      bodies_.push_back(SimTK::MobilizedBody::Free(
          matter_.Ground(), SimTK::Transform(vec(item.centre)), rigid, SimTK::Transform()));
      return;
    }
    const Vec3 arm = vec(item.centre - item.hinge);
    const SimTK::Body::Rigid rigid(SimTK::MassProperties(
        item.mass, arm, inertia_of(item.J).shiftFromMassCenter(arm, item.mass)));
    const SimTK::Rotation axes(SimTK::UnitVec3(vec(item.axis)), SimTK::ZAxis);
    SimTK::MobilizedBody parent = body({item.parent, {}});
    const SimTK::MobilizedBody::Pin pin(
        parent, SimTK::Transform(axes, vec(item.hinge - origin(item.parent))), rigid,
        SimTK::Transform(axes));
    bodies_.push_back(pin);
    if (item.stiffness > 0) {
      SimTK::Force::MobilityLinearSpring(forces_, pin, SimTK::MobilizerQIndex(0), item.stiffness,
                                         0);
    }
    if (item.damping > 0) {
      SimTK::Force::MobilityLinearDamper(forces_, pin, SimTK::MobilizerUIndex(0), item.damping);
    }
  }
  void add(const Spring& spring) {
    if (spring.input >= 0) {
      // Simbody owns what a force is given.
      SimTK::Force::Custom(forces_,
                           new ShakenSpring(body(spring.to), station(spring.to), spring, floor_));
      return;
    }
    const double length = (spring.to.position - spring.from.position).norm();
    SimTK::Force::TwoPointLinearSpring(forces_, body(spring.from), station(spring.from),
                                       body(spring.to), station(spring.to), spring.stiffness,
                                       length);
    SimTK::Force::TwoPointLinearDamper(forces_, body(spring.from), station(spring.from),
                                       body(spring.to), station(spring.to), spring.damping);
  }

  const Mechanism& mechanism_;
  const HeldFloor& floor_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::Gravity gravity_;
  std::vector<SimTK::MobilizedBody> bodies_;
};

}  // namespace

Run simbody_run(const Mechanism& mechanism, const Eigen::MatrixXd& inputs,
                const std::string& method, double accuracy) {
  HeldFloor floor(inputs, mechanism.sample_time);
  System system(mechanism, floor);
  SimTK::State state = system.start();
  const auto integrator = make_integrator(system.system(), method, accuracy);
  system.change(state);
  system.system().realize(state, SimTK::Stage::Acceleration);
  Eigen::VectorXd before =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mechanism.outputs.size()));
  Run result;
  result.accelerations.resize(before.size(), floor.samples());
  integrator->initialize(state);
  const bool shaken = !inputs.isZero(0);
  const double begin = thread_seconds();
  for (Eigen::Index k = 0; k < floor.samples(); ++k) {
    const double end = static_cast<double>(k + 1) * floor.sample_time();
    integrator->stepTo(end, end);
    while (integrator->getState().getTime() < end) integrator->stepTo(end, end);
    system.system().realize(integrator->getState(), SimTK::Stage::Velocity);
    const Eigen::VectorXd now = system.velocities(integrator->getState());
    result.accelerations.col(k) = (now - before) / floor.sample_time();
    before = now;
    if (k + 1 == floor.samples()) break;
    floor.next();
    if (!shaken) continue;
    SimTK::State& advanced = integrator->updAdvancedState();
    system.change(advanced);
    advanced.invalidateAllCacheAtOrAbove(SimTK::Stage::Dynamics);
    integrator->reinitialize(SimTK::Stage::Position, false);
  }
  result.seconds = thread_seconds() - begin;
  return result;
}

}  // namespace stillframe::race

#include "tests/core/scenes.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const std::string scenes_folder = STILLFRAME_SOURCE_DIR "/config/scenes/";
const std::string here = "test scene";

Vector3d position(const Scene& scene, const std::string& node) {
  return std::find_if(scene.nodes.begin(), scene.nodes.end(),
                      [&](const SceneNode& n) { return n.name == node; })
      ->position;
}

void add_node(Scene& scene, const std::string& name, const Vector3d& at) {
  scene.nodes.push_back({name, here, at});
}

SceneConstraint constraint(const std::string& node, const std::vector<Vector3d>& directions) {
  SceneConstraint item;
  item.node = node;
  item.place = here;
  item.directions = directions;
  return item;
}

std::vector<Vector3d> world_axes() {
  return {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
}
std::vector<Vector3d> oblique_axes() {
  return {Vector3d(1, 2, 2) / 3, Vector3d(2, 1, -2) / 3, Vector3d(2, -2, 1) / 3};
}

SceneElement truss(const std::string& name, const std::string& p, const std::string& q,
                   double stiffness, double damping, double preload) {
  SceneElement element;
  element.name = name;
  element.place = here;
  element.node_p = p;
  element.node_q = q;
  element.zero = {false};
  element.stiffness = Eigen::MatrixXd::Constant(1, 1, stiffness);
  element.damping = Eigen::MatrixXd::Constant(1, 1, damping);
  element.preload = Eigen::VectorXd::Constant(1, preload);
  return element;
}

SceneElement rigid(const std::string& name, SceneElement::Kind kind, const std::string& p,
                   const std::string& q) {
  SceneElement element;
  element.name = name;
  element.place = here;
  element.kind = kind;
  element.node_p = p;
  element.node_q = q;
  element.n_deformations = kind == SceneElement::Kind::truss ? 1 : 6;
  element.zero.assign(static_cast<size_t>(element.n_deformations), true);
  return element;
}

/// A full inertia matrix with the given principal moments (kg m^2) in a turned frame.
Matrix3d turned_inertia(const Vector3d& moments) {
  const Matrix3d Q = random_rotation(11);
  const Matrix3d J = Q * moments.asDiagonal() * Q.transpose();
  return 0.5 * (J + J.transpose());
}

SceneMass body(const std::string& node, double mass, const Vector3d& moments) {
  return {node, here, mass, turned_inertia(moments), true};
}

}  // namespace

SceneDof dof_of_element(const std::string& element, int mode) {
  SceneDof dof;
  dof.place = here;
  dof.element = element;
  dof.mode = mode;
  return dof;
}
SceneDof dof_along(const std::string& node, const Vector3d& direction) {
  SceneDof dof;
  dof.place = here;
  dof.node = node;
  dof.direction = direction;
  return dof;
}
SceneDof dof_euler(const std::string& node, int parameter) {
  SceneDof dof;
  dof.place = here;
  dof.node = node;
  dof.euler_parameter = parameter;
  return dof;
}
SceneSignal node_signal(const std::string& name, const std::string& node, Quantity quantity,
                        const Vector3d& direction) {
  return {name, here, node, "", quantity, direction.normalized(), 1};
}
SceneSignal element_signal(const std::string& name, const std::string& element, Quantity quantity,
                           int mode) {
  return {name, here, "", element, quantity, Vector3d::Zero(), mode};
}

SceneLoad force_at(const std::string& node, const Vector3d& force) {
  SceneLoad load;
  load.node = node;
  load.place = here;
  load.force = force;
  return load;
}

MotionState position_state(const Model& model, const Eigen::VectorXd& q_d) {
  MotionState state(model);
  state.q_d = q_d;
  return state;
}

Scene frame_scene() { return read_scene(scenes_folder + "metrology_frame.yaml"); }
Scene cart_scene() { return read_scene(scenes_folder + "cart.yaml"); }

Scene cart_by_position() {
  Scene scene = cart_scene();
  scene.dofs = {dof_along("mass", Vector3d::UnitX())};
  return scene;
}

Scene by_lens_coordinates(Scene scene) {
  scene.dofs.clear();
  for (const Vector3d& axis : world_axes()) scene.dofs.push_back(dof_along("lens", axis));
  for (int i = 1; i <= 3; ++i) scene.dofs.push_back(dof_euler("lens", i));
  return scene;
}

Scene preloaded_frame() {
  Scene scene = frame_scene();
  const double weight = 7357.5;
  const std::vector<SceneElement> elements = scene.elements;
  int i = 0;
  for (const SceneElement& leg : elements) {
    if (leg.kind != SceneElement::Kind::truss) continue;
    ++i;
    const bool vertical = leg.name.back() == 'v';
    const double tension = 500.0 * i;
    SceneElement& own = scene.elements[static_cast<size_t>(&leg - elements.data())];
    own.preload.setConstant(tension - (vertical ? weight / 3 : 0.0));
    own.damping.setConstant(200.0 * i);
    const std::string node = "opposite_" + leg.name;
    const Vector3d mount = position(scene, leg.node_q);
    add_node(scene, node, 2 * mount - position(scene, leg.node_p));
    scene.elements.push_back(truss("truss_" + leg.name, node, leg.node_q, 1e6 * (1 + 0.1 * i),
                                   300.0 + 20.0 * i, tension));
    (vertical ? scene.prescribed : scene.supports)
        .push_back(constraint(node, vertical ? oblique_axes() : world_axes()));
  }
  scene.loads.push_back(force_at("lens", Vector3d(0, 0, -weight)));
  return scene;
}

Scene mechanism() {
  Scene scene;
  scene.title = scene.file = here;
  scene.dofs_place = here;
  add_node(scene, "joint", {0, 0, 0});
  add_node(scene, "tip", {0.5, 0.1, 0.2});
  add_node(scene, "slider", {1.2, 0.3, -0.1});
  add_node(scene, "wall", {1.9, 0.9, -0.4});
  add_node(scene, "anchor", {0.4, 0.8, 0.3});
  scene.masses = {body("joint", 0.0, {0.1, 0.15, 0.2}),
                  body("tip", 2.0, {0.02, 0.03, 0.04}),
                  {"slider", here, 3.0, Matrix3d::Zero(), false}};
  scene.elements = {rigid("crank", SceneElement::Kind::rigid_beam, "joint", "tip"),
                    rigid("rod", SceneElement::Kind::truss, "tip", "slider"),
                    truss("spring", "wall", "slider", 2e4, 30, 120),
                    truss("tie", "anchor", "tip", 3e4, 20, 250)};
  scene.supports = {constraint("joint", world_axes()), constraint("anchor", world_axes()),
                    constraint("slider", {oblique_axes()[0], oblique_axes()[2]})};
  scene.prescribed = {constraint("wall", oblique_axes())};
  for (int i = 1; i <= 3; ++i) scene.dofs.push_back(dof_euler("joint", i));

  // At the slider the load takes the spring away and presses c along the rail, which the rod
  // carries as N; at the tip it takes away what rod and tie pull, but for a pull along the crank,
  // which the crank carries.
  const auto unit = [&](const char* from, const char* to) {
    return (position(scene, to) - position(scene, from)).normalized();
  };
  const Vector3d rail = oblique_axes()[1], rod = unit("tip", "slider");
  const double c = 90.0, N = c / rod.dot(rail);
  scene.loads = {
      {"slider", here, 120.0 * unit("wall", "slider") + c * rail},
      {"tip", here, -N * rod + 250.0 * unit("anchor", "tip") + 400.0 * unit("joint", "tip")}};
  return scene;
}

Scene free_body() {
  Scene scene;
  scene.title = scene.file = here;
  scene.dofs_place = here;
  add_node(scene, "body", {0.3, -0.2, 0.1});
  scene.masses = {body("body", 3.0, {1.0, 2.0, 2.5})};
  for (const Vector3d& axis : world_axes()) scene.dofs.push_back(dof_along("body", axis));
  for (int i = 1; i <= 3; ++i) scene.dofs.push_back(dof_euler("body", i));
  return scene;
}

Scene strung_mass(double tension) {
  Scene scene;
  scene.title = scene.file = here;
  scene.dofs_place = here;
  add_node(scene, "left", {-0.5, 0, 0});
  add_node(scene, "mass", {0, 0, 0});
  add_node(scene, "right", {0.8, 0, 0});
  scene.masses = {{"mass", here, 4.0, Matrix3d::Zero(), false}};
  scene.elements = {truss("left_string", "left", "mass", 1000, 0, tension),
                    truss("right_string", "mass", "right", 3000, 0, tension)};
  scene.supports = {constraint("left", world_axes()), constraint("right", world_axes())};
  for (const Vector3d& axis : world_axes()) scene.dofs.push_back(dof_along("mass", axis));
  return scene;
}

void use_all_signals_of_frame(Scene& scene) {
  scene.inputs = {node_signal("w_1", "floor_1t", Quantity::acceleration, {1, 2, 3}),
                  node_signal("w_2", "floor_2v", Quantity::velocity, {0, 0, 1}),
                  node_signal("w_3", "opposite_leg_1v", Quantity::position, {-1, 1, 2}),
                  node_signal("f_1", "mount_2", Quantity::force, {1, 1, 0}),
                  node_signal("f_2", "lens", Quantity::force, {0, 1, -1}),
                  element_signal("s_1", "leg_1v", Quantity::stress),
                  element_signal("s_2", "truss_leg_3t", Quantity::stress)};
  scene.outputs = {node_signal("y_1", "lens", Quantity::position, {1, 0, 2}),
                   node_signal("y_2", "mount_1", Quantity::velocity, {0, 1, 0}),
                   node_signal("y_3", "mount_3", Quantity::acceleration, {1, -1, 1}),
                   node_signal("y_4", "floor_1t", Quantity::acceleration, {0, 1, 0}),
                   element_signal("y_5", "leg_1v", Quantity::stress),
                   element_signal("y_6", "truss_leg_1v", Quantity::stress),
                   element_signal("y_7", "truss_leg_2v", Quantity::deformation)};
}

void use_all_signals_of_mechanism(Scene& scene) {
  scene.inputs = {node_signal("w_1", "wall", Quantity::acceleration, {1, 2, 3}),
                  node_signal("w_2", "wall", Quantity::position, {0, 0, 1}),
                  node_signal("f_1", "slider", Quantity::force, {1, 1, 0}),
                  node_signal("f_2", "tip", Quantity::force, {0, 1, -1}),
                  element_signal("s_1", "spring", Quantity::stress)};
  scene.outputs = {node_signal("y_1", "slider", Quantity::position, {1, 0, 2}),
                   node_signal("y_2", "tip", Quantity::velocity, {0, 1, 0}),
                   node_signal("y_3", "slider", Quantity::acceleration, {1, -1, 1}),
                   element_signal("y_4", "spring", Quantity::stress),
                   element_signal("y_5", "tie", Quantity::deformation)};
}

Scene moved(Scene scene, const Matrix3d& Q, const Vector3d& t) {
  for (SceneNode& node : scene.nodes) node.position = Q * node.position + t;
  for (SceneMass& mass : scene.masses) {
    const Matrix3d J = Q * mass.inertia * Q.transpose();
    mass.inertia = 0.5 * (J + J.transpose());
  }
  for (auto* list : {&scene.supports, &scene.prescribed}) {
    for (SceneConstraint& item : *list) {
      for (Vector3d& d : item.directions) d = Q * d;
    }
  }
  for (SceneDof& dof : scene.dofs) {
    if (dof.direction) dof.direction = Q * *dof.direction;
  }
  scene.gravity = Q * scene.gravity;
  for (SceneElement& element : scene.elements) {
    element.axis = Q * element.axis;
    element.beam.orientation = Q * element.beam.orientation;
  }
  for (SceneLoad& load : scene.loads) {
    load.force = Q * load.force;
    load.torque = Q * load.torque;
  }
  for (auto* list : {&scene.inputs, &scene.outputs, &scene.monitors}) {
    for (SceneSignal& signal : *list) signal.direction = Q * signal.direction;
  }
  return scene;
}

Scene renumbered(Scene scene, unsigned seed) {
  std::mt19937 engine(seed);
  std::shuffle(scene.nodes.begin(), scene.nodes.end(), engine);
  std::shuffle(scene.elements.begin(), scene.elements.end(), engine);
  std::shuffle(scene.masses.begin(), scene.masses.end(), engine);
  std::shuffle(scene.supports.begin(), scene.supports.end(), engine);
  std::shuffle(scene.prescribed.begin(), scene.prescribed.end(), engine);
  for (SceneElement& element : scene.elements) std::swap(element.node_p, element.node_q);
  return scene;
}

Scene in_millimetres(Scene scene) {
  for (SceneNode& node : scene.nodes) node.position *= 1e3;
  for (SceneMass& mass : scene.masses) {
    mass.mass *= 1e-3;
    mass.inertia *= 1e3;
  }
  for (SceneElement& element : scene.elements) {
    element.stiffness *= 1e-3;
    element.damping *= 1e-3;
  }
  return scene;
}

Matrix3d random_rotation(unsigned seed) {
  std::mt19937 engine(seed);
  const Eigen::Vector4d q = random_vector(4, engine).normalized();
  return Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix();
}

Eigen::VectorXd random_vector(Index n, std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::VectorXd v(n);
  for (Index i = 0; i < n; ++i) v(i) = uniform(engine);
  return v;
}

MotionState random_motion(const Model& model, double size, double rate, std::mt19937& engine) {
  MotionState state(model);
  state.q_d = size * random_vector(model.n_d, engine);
  state.q_d_dot = rate * random_vector(model.n_d, engine);
  state.q_r = size * random_vector(model.n_r, engine);
  state.q_r_dot = rate * random_vector(model.n_r, engine);
  state.q_r_ddot = 10 * rate * random_vector(model.n_r, engine);
  return state;
}

}  // namespace stillframe::test

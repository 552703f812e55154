#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_builder.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/infinity.hpp"
#include "tests/core/reader_scenes.hpp"
#include "tests/support/scratch_folder.hpp"

// A scene in C++ against the same scene in a file.
namespace stillframe::test {
namespace {

namespace fs = std::filesystem;
using Quant = Quantity;
using Kind = SceneElement::Kind;

/// All numbers by their bits; directions, which the reader makes unit vectors once more, to 14
/// digits.
class Account {
 public:
  template <class... Values>
  void add(const char* what, const Values&... values) {
    out_ << what;
    (one(values), ...);
    out_ << "\n";
  }
  std::string text() const { return out_.str(); }

 private:
  void one(double value) { out_ << " " << std::hexfloat << value; }
  void one(int value) { out_ << " " << value; }
  void one(bool value) { out_ << " " << value; }
  void one(const std::optional<double>& value) { one(value ? *value : std::nan("")); }
  template <class Derived>
  void one(const Eigen::MatrixBase<Derived>& values) {
    out_ << " (" << values.rows() << " x " << values.cols() << ")";
    for (Eigen::Index i = 0; i < values.size(); ++i) one(double{values.reshaped()(i)});
  }
  /// The parts of a divided beam cannot be called by their names in another scene.
  void one(std::string name) {
    std::replace(name.begin(), name.end(), '/', '_');
    out_ << " '" << name << "'";
  }

  std::ostringstream out_;
};

Eigen::Vector3d to_14_digits(const Eigen::Vector3d& direction) {
  return (direction * 1e14).array().round() + 0.0;
}

void account_for(const SceneConstraint& c, const char* what, Account& account) {
  account.add(what, c.node, c.rotation, c.element, c.mode, c.value, c.rate, c.acceleration);
  for (const auto& direction : c.directions) account.add(" along", to_14_digits(direction));
}

void account_for(const SceneElement& e, Account& account) {
  account.add("element", e.name, static_cast<int>(e.kind), e.node_p, e.node_q,
              static_cast<int>(e.n_deformations), e.stiffness, e.damping, e.preload,
              to_14_digits(e.axis));
  for (const bool zero : e.zero) account.add(" zero", zero);
  const SceneBeam& b = e.beam;
  account.add(" beam", b.EA, b.GJ, b.EI_y, b.EI_z, b.shear_y, b.shear_z, b.mass_per_length,
              b.inertia_per_length, b.damping_time, b.lumped_mass, b.second_order,
              to_14_digits(b.orientation));
}

std::string account_of(const Scene& scene) {
  Account account;
  account.add("scene", scene.title, scene.planar, scene.gravity,
              static_cast<int>(scene.operating_point), scene.automatic_dofs);
  if (scene.modal_damping) {
    for (const auto& [hz, ratio] : scene.modal_damping->points) account.add("modal", hz, ratio);
  }
  for (const auto& n : scene.nodes) account.add("node", n.name, n.position);
  for (const auto& m : scene.masses) {
    account.add("mass", m.node, m.mass, m.inertia, m.has_inertia);
  }
  for (const auto& e : scene.elements) account_for(e, account);
  for (const auto& c : scene.supports) account_for(c, "support", account);
  for (const auto& c : scene.prescribed) account_for(c, "prescribed", account);
  for (const auto& d : scene.dofs) {
    account.add("dof", d.element, d.node, d.mode,
                to_14_digits(d.direction.value_or(Eigen::Vector3d::Zero())), d.euler_parameter,
                d.rotation, d.value, d.rate);
  }
  for (const auto& l : scene.loads) account.add("load", l.node, l.force, l.torque, l.follows);
  for (const auto* signals : {&scene.inputs, &scene.outputs, &scene.monitors}) {
    account.add("signals");
    for (const auto& s : *signals) {
      account.add(" ", s.name, s.node, s.element, static_cast<int>(s.quantity),
                  to_14_digits(s.direction), s.mode);
    }
  }
  if (scene.controller) {
    const SceneController& c = *scene.controller;
    account.add("controller", c.sample_rate_hz, c.delay_samples, c.leak_hz, c.high_pass_hz,
                c.lead_samples, c.roll_off_hz, c.force_limit_n, static_cast<int>(c.order),
                static_cast<int>(c.reduction), static_cast<int>(c.realisation));
    if (c.feed_forward) {
      const SceneFeedForward& f = *c.feed_forward;
      account.add(" feed_forward", f.to_hz, f.corner_hz, f.target_hz, f.damping_ratio, f.at_most_db,
                  f.actuator_error, f.noise_over_floor, f.taps);
    }
    if (c.law) account.add(" law", c.law->file, c.law->bytes);
    for (const auto& leg : c.legs) account.add(" leg", leg);
    for (const double hz : c.target_hz) account.add(" hz", hz);
    for (const double ratio : c.damping_ratio) account.add(" ratio", ratio);
  }
  return account.text();
}

/// The linear model by its bits.
std::string linear_account_of(const Scene& scene) {
  const Model model = make_model(scene);
  const LinearModel linear = linearise(model, scene.inputs, scene.outputs);
  Account account;
  account.add("M", linear.M, linear.C, linear.D, linear.K, linear.N, linear.G, linear.B);
  account.add("M_r", linear.M_r, linear.C_r, linear.D_r, linear.K_r, linear.N_r, linear.G_r);
  account.add("Y", linear.Y_p, linear.Y_v, linear.Y_a);
  account.add("R", linear.R_p, linear.R_v, linear.R_a, linear.D_u);
  return account.text();
}

/// Line by line, so that a failure shows what differs and no more.
void expect_same_account(const std::string& built, const std::string& read) {
  std::istringstream left(built), right(read);
  for (std::string a, b; std::getline(right, b) && std::getline(left, a);) ASSERT_EQ(a, b);
  EXPECT_EQ(built.size(), read.size());
}

void expect_same_scene(const SceneBuilder& builder, const Scene& read) {
  const Scene built = builder.build();
  SCOPED_TRACE(built.text);
  expect_same_account(account_of(built), account_of(read));
}

void expect_same_model(const SceneBuilder& builder, const Scene& read) {
  expect_same_scene(builder, read);
  const std::string linear = linear_account_of(read);
  expect_same_account(linear_account_of(builder.build()), linear);
  EXPECT_EQ(linear.find("nan"), std::string::npos);
}

Scene shipped(const std::string& name) {
  return read_scene(fs::path(STILLFRAME_SOURCE_DIR) / "config/scenes" / name);
}

SceneBuilder cart_builder() {
  SceneBuilder builder("Spring-mass-damper on a cart");
  builder.node("cart", {0, 0, 0})
      .node("mass", {1, 0, 0})
      .mass("mass", 2)
      .truss("spring", "cart", "mass", {.stiffness = 800, .damping = 4})
      .support("cart", {"y", "z"})
      .support("mass", {"y", "z"})
      .prescribe("cart", {"x"})
      .dof_of_element("spring")
      .input("x1", Quant::position, "cart", "x")
      .output("x2", Quant::position, "mass", "x");
  return builder;
}

TEST(SceneBuilder, MakesTheCart) { expect_same_model(cart_builder(), shipped("cart.yaml")); }

TEST(SceneBuilder, MakesTheFrameOnSixLegs) {
  SceneBuilder builder("Metrology frame on six piezo legs");
  builder.node("lens", {0, 0, 0}).mass("lens", 750, {57, 57, 45});
  const Eigen::Vector3d mounts[] = {
      {0.6, 0.0, -0.1}, {-0.3, 0.519615242270663, -0.1}, {-0.3, -0.519615242270663, -0.1}};
  const Eigen::Vector3d beside[] = {{0.6, -0.15, -0.1},
                                    {-0.170096189432334, 0.594615242270663, -0.1},
                                    {-0.429903810567666, -0.444615242270663, -0.1}};
  const Eigen::Vector3d along[] = {
      {0, 1, 0}, {-0.866025403784439, -0.5, 0}, {0.866025403784438, -0.5, 0}};
  ControllerKeys controller{.target_hz = 5, .damping_ratio = 0.7};
  for (size_t i = 0; i < 3; ++i) {
    const std::string n = std::to_string(i + 1), mount = "mount_" + n;
    builder.node(mount, mounts[i])
        .node("floor_" + n + "t", beside[i])
        .node("floor_" + n + "v", {mounts[i].x(), mounts[i].y(), -0.25})
        .rigid_beam("arm_" + n, "lens", mount);
  }
  for (size_t i = 0; i < 3; ++i) {
    const std::string n = std::to_string(i + 1), mount = "mount_" + n;
    for (const std::string& leg : {n + "t", n + "v"}) {
      const SceneDirection direction = leg == n + "t" ? SceneDirection(along[i]) : "z";
      builder.truss("leg_" + leg, "floor_" + leg, mount, {.stiffness = 3.95e6})
          .prescribe("floor_" + leg, {"x", "y", "z"})
          .dof_of_element("leg_" + leg)
          .input("floor_" + leg, Quant::acceleration, "floor_" + leg, direction)
          .output("frame_" + leg, Quant::acceleration, mount, direction);
      controller.legs.push_back("leg_" + leg);
    }
  }
  for (const char* axis : {"x", "y", "z"}) {
    builder.monitor(std::string("floor_") + axis, Quant::acceleration, "floor_1v", axis);
  }
  for (const char* axis : {"x", "y", "z"}) {
    builder.monitor(std::string("lens_") + axis, Quant::acceleration, "lens", axis);
  }
  const Scene read = shipped("metrology_frame.yaml");
  const SceneController& there = read.controller.value();
  controller.sample_rate_hz = there.sample_rate_hz;
  controller.delay_samples = there.delay_samples;
  controller.lead_samples = there.lead_samples;
  controller.leak_hz = there.leak_hz;
  controller.force_limit_n = there.force_limit_n;
  builder.controller(controller);
  expect_same_model(builder, read);
}

TEST(SceneBuilder, MakesADividedBeam) {
  SceneBuilder builder("Cantilever");
  builder.planar()
      .node("root", {0, 0})
      .node("tip", {1, 0})
      .beam("beam", "root", "tip",
            {.EA = 4e6, .EI = 39.47841760435743, .mass_per_length = 1, .divide = 8})
      .support("root", {"x", "y", "rotation"})
      .dofs_of("beam")
      .input("push", Quant::force, "tip", "y")
      .input("twist", Quant::torque, "tip")
      .output("middle", Quant::position, "beam/4", "y")
      .output("tip", Quant::position, "tip", "y")
      .output("tip_acceleration", Quant::acceleration, "tip", "y")
      .output("clamping_force", Quant::reaction, "root", "y")
      .output("clamping_moment", Quant::reaction_moment, "root");
  expect_same_model(builder, shipped("cantilever.yaml"));
}

TEST(SceneBuilder, MakesABeamWithLumpedMassInSpace) {
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(6, 6);
  coupling.topLeftCorner(2, 2) << 30, 10, 10, 20;
  SceneBuilder builder("Rod");
  builder.node("root", {0, 0, 0})
      .node("tip", {0.3, 0.1, 0.7})
      .beam("rod", "root", "tip",
            {.orientation = {0, 1, 0},
             .EA = 1e5,
             .GJ = 30,
             .EI_y = 20,
             .EI_z = 10,
             .mass_per_length = 2,
             .lumped_mass = true,
             .stiffness = coupling,
             .damping = {1, 2, 3, 4, 5, 6},
             .damping_time = 1e-4})
      .mass("tip", 1, Eigen::Matrix3d{{0.1, 0.01, 0}, {0.01, 0.2, 0}, {0, 0, 0.2}})
      .support("root", {"x", "y", "z", "rotation"})
      .automatic_dofs()
      .gravity({0, 0, -9.81})
      .input("push", Quant::force, "tip", "x")
      .output("bend", Quant::stress, "rod", 3);
  expect_same_model(builder, parse_scene(R"(title: Rod
gravity: [0, 0, -9.81]
nodes:
  root: {position: [0, 0, 0]}
  tip: {position: [0.3, 0.1, 0.7]}
masses:
  - {node: tip, mass: 1, inertia: [[0.1, 0.01, 0], [0.01, 0.2, 0], [0, 0, 0.2]]}
elements:
  rod: {type: beam, nodes: [root, tip], orientation: y, EA: 1e5, GJ: 30, EI_y: 20, EI_z: 10,
    mass_per_length: 2, mass: lumped, damping_time: 1e-4, damping: [1, 2, 3, 4, 5, 6],
    stiffness: [[30, 10, 0, 0, 0, 0], [10, 20, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0],
                [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]]}
supports: [{nodes: [root], fix: [x, y, z, rotation]}]
dofs: auto
inputs: [{name: push, force: tip, along: x}]
outputs: [{name: bend, stress: rod, mode: 3}]
)",
                                         "rod.yaml"));
}

TEST(SceneBuilder, MakesPendulumsOnHinges) {
  SceneBuilder builder("Two pendulums");
  const std::string text = R"(title: Two pendulums
gravity: [0, 0, -9.81]
nodes:
  ceiling: {position: [0, 0, 0]}
  top: {position: [0, 0, 0]}
  bob: {position: [0, 0, -1]}
  pin: {position: [0, 0, -1]}
  end: {position: [0, 0, -1.5]}
masses:
  - {node: bob, mass: 2, inertia: [0.01, 0.02, 0.02]}
  - {node: end, mass: 1}
elements:
  joint: {type: hinge, nodes: [ceiling, top], axis: y, damping: 0.1}
  rod: {type: rigid_beam, nodes: [top, bob]}
  knee: {type: hinge, nodes: [bob, pin], axis: [1, 1, 0], stiffness: [3, 0, 0]}
  shin: {type: rigid_beam, nodes: [pin, end]}
supports: [{nodes: [ceiling], fix: [x, y, z, rotation]}]
dofs: [{element: joint}, {element: knee}]
inputs: [{name: torque, stress: joint}]
outputs: [{name: end, acceleration: end, along: x}]
)";
  // In another order: what is named need not be there yet.
  builder.input("torque", Quant::stress, "joint").dof_of_element("joint").dof_of_element("knee");
  builder.output("end", Quant::acceleration, "end", "x");
  builder.hinge("joint", "ceiling", "top", {.axis = "y", .damping = 0.1});
  builder.rigid_beam("rod", "top", "bob");
  builder.hinge("knee", "bob", "pin", {.axis = {1, 1, 0}, .stiffness = {3, 0, 0}});
  builder.rigid_beam("shin", "pin", "end");
  builder.mass("bob", 2, {0.01, 0.02, 0.02}).mass("end", 1);
  builder.support("ceiling", {"x", "y", "z", "rotation"});
  builder.node("ceiling", {0, 0, 0}).node("top", {0, 0, 0}).node("bob", {0, 0, -1});
  builder.node("pin", {0, 0, -1}).node("end", {0, 0, -1.5}).gravity({0, 0, -9.81});
  expect_same_model(builder, parse_scene(text, "pendulums.yaml"));
}

TEST(SceneBuilder, HasEverySpatialKey) {
  SceneBuilder builder("Crane");
  builder.gravity({0, 0, -9.81})
      .node("foot", {0, 0, 0})
      .node("top", {0, 0, 1})
      .node("jib", {0, 0, 1})
      .node("tip", {3, 0.5, 1})
      .node("anchor", {2, 0, 0})
      .mass("tip", 2, {1, 2, 3})
      .mass("boom/1", 0.5)
      .beam("mast", "foot", "top",
            {.orientation = {0, 2, 0},
             .EA = 1e7,
             .GJ = 2e4,
             .EI_y = 3e4,
             .EI_z = 4e4,
             .shear_y = 5e6,
             .shear_z = 6e6,
             .mass_per_length = 7,
             .inertia_per_length = 0.08,
             .lumped_mass = true,
             .second_order = true,
             .damping_time = 1e-3,
             .preload = {-20, 0, 0, 0, 0, 1}})
      .hinge("pivot", "top", "jib",
             {.axis = {0, 3, 0}, .stiffness = 100, .damping = 2, .preload = 5})
      .beam("boom", "jib", "tip",
            {.orientation = "z",
             .EI_y = 1e4,
             .EI_z = 1e4,
             .rigid = {2, 1},
             .preload = {0, 0, 1, 2, 3, 4},
             .divide = 4})
      .beam("rod", "tip", "anchor",
            {.orientation = "y", .mass_per_length = 2, .rigid = {1, 2, 3, 4, 5, 6}})
      .hinge("ball", "top", "jib",
             {.axis = "x",
              .ball = true,
              .stiffness = {1, 2, 3},
              .damping = Eigen::Matrix3d{{2, 1, 0}, {1, 2, 0}, {0, 0, 0}},
              .preload = {1, 2, 3}})
      .hinge("wrist", "top", "jib", {.axis = "z", .rigid = {1, 3}, .stiffness = 7, .preload = 5})
      .truss("cable", "anchor", "tip", {.stiffness = 1e5, .damping = 3, .preload = 40})
      .truss("stay", "anchor", "top", {.rigid = true})
      .rigid_beam("arm", "foot", "anchor")
      .support("foot", {"x", {0, 3, 4}, "rotation"})
      .support("anchor", {"x", {0, 3, 4}, "rotation"})
      .prescribe("foot", {"z", "x"}, {.value = 0.1, .rate = 0.2, .acceleration = 0.3})
      .prescribe("anchor", {"z", "x"}, {.value = 0.1, .rate = 0.2, .acceleration = 0.3})
      .prescribe_element("pivot", {}, {.rate = 10})
      .prescribe_element("boom/2", 6)
      .dofs_of("mast")
      .dofs_of("boom")
      .dofs_of("pivot")
      .dof_of_element("cable")
      .dof_of_element("pivot")
      .dof_of_element("ball", 3)
      .dof_of_element("boom/4", 5)
      .dof_of_node("tip", {0, 0, -2})
      .dof_of_euler_parameter("tip", 0)
      .load("tip", {.force = {1, 2, 3}, .torque = {4, 5, 6}, .follows = true})
      .load("top", {.torque = {0, 0, 1}})
      .input("i1", Quant::acceleration, "foot", "z")
      .input("i2", Quant::torque, "tip", {2, 0, 0})
      .input("i3", Quant::stress, "boom/1", 4)
      .input("i4", Quant::deformation_rate, "pivot")
      .output("o1", Quant::reaction, "foot", "x")
      .output("o2", Quant::reaction_moment, "foot", "y")
      .output("o3", Quant::angular_velocity, "tip", "z")
      .output("o4", Quant::deformation_acceleration, "mast", 2)
      .output("o5", Quant::position, "boom/3", "z");
  expect_same_scene(builder, parse_scene(every_spatial_key, "crane.yaml"));
}

TEST(SceneBuilder, HasEveryPlanarKey) {
  SceneBuilder builder("Slider and crank");
  builder.planar()
      .as_written()
      .gravity({0, -9.81})
      .modal_damping((Eigen::MatrixXd(2, 2) << 1, 0.02, 30, 0.01).finished())
      .node("ground", {0, 0})
      .node("crank", {0, 0, 0})
      .node("pin", {0.3, 0})
      .node("rod", {0.3, 0})
      .node("slider", {1, 0})
      .mass("slider", 2, 0.3)
      .hinge("motor", "ground", "crank")
      .rigid_beam("arm", "crank", "pin")
      .hinge("knee", "pin", "rod", {.stiffness = 4, .damping = {5}, .preload = {6}})
      .beam("link", "rod", "slider", {.EA = 1e6, .EI = 20, .shear = 3e5, .mass_per_length = 0.4})
      .support("ground", {"x", "y", "rotation"})
      .support("slider", {"y"})
      .prescribe_element("motor", {}, {.value = 0.1, .rate = 10, .acceleration = -1})
      .prescribe("ground", {"rotation", {1, 1}})
      .dof_of_element("link", 2, {.value = 1e-3, .rate = -2e-3})
      .dof_of_rotation("slider")
      .load("slider", {.force = {1, 2}, .torque = 3})
      .input("turn", Quant::angular_acceleration, "ground")
      .output("moment", Quant::reaction_moment, "ground")
      .output("place", Quant::position, "slider", {3, 4});
  expect_same_scene(builder, parse_scene(every_planar_key, "crank.yaml"));
}

/// A scene that was read, once more by calls.
class Rebuilt {
 public:
  explicit Rebuilt(const Scene& scene) : scene_(scene), builder_(title_of(scene)) {
    if (scene.planar) builder_.planar();
    if (scene.operating_point == OperatingPoint::as_written) builder_.as_written();
    builder_.gravity(numbers(scene.gravity));
    for (const auto& n : scene.nodes) {
      if (!n.amplitudes) builder_.node(plain(n.name), numbers(n.position));
    }
    for (const auto& m : scene.masses) {
      SceneNumbers inertia;
      if (m.has_inertia && scene.planar) inertia = m.inertia(2, 2);
      if (m.has_inertia && !scene.planar) inertia = m.inertia;
      builder_.mass(plain(m.node), m.mass, inertia);
    }
    for (const auto& e : scene.elements) add(e);
    for (const auto& c : scene.supports) {
      const bool unused = c.node.find("/modes_") != std::string::npos;  // the reader's own
      if (!unused) builder_.support(plain(c.node), directions(c));
    }
    for (const auto& c : scene.prescribed) add_prescribed(c);
    if (scene.automatic_dofs) builder_.automatic_dofs();
    for (const auto& d : scene.dofs) add(d);
    for (const auto& l : scene.loads) {
      SceneNumbers torque = l.torque;
      if (scene.planar) torque = l.torque.z();
      builder_.load(plain(l.node),
                    {.force = numbers(l.force), .torque = torque, .follows = l.follows});
    }
    add_signals();
    if (scene.controller) add(*scene.controller);
  }
  const SceneBuilder& builder() const { return builder_; }

 private:
  static std::string title_of(const Scene& scene) {
    return scene.title.substr(0, scene.title.find(" (snapshot)"));
  }
  static std::string plain(std::string name) {
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
  }
  SceneNumbers numbers(const Eigen::Vector3d& v) const {
    return scene_.planar ? SceneNumbers(v.head<2>()) : SceneNumbers(v);
  }
  SceneDirection direction(const Eigen::Vector3d& v) const {
    return scene_.planar ? SceneDirection(v.head<2>()) : SceneDirection(v);
  }
  std::vector<SceneDirection> directions(const SceneConstraint& c) const {
    std::vector<SceneDirection> all;
    for (const auto& each : c.directions) all.push_back(direction(each));
    if (c.rotation) all.emplace_back("rotation");
    return all;
  }
  static std::optional<double> unless_0(double value) {
    return value == 0 ? std::nullopt : std::optional(value);
  }

  void add(const SceneElement& e) {
    Eigen::VectorXd rigid(std::count(e.zero.begin(), e.zero.end(), true));
    for (size_t i = 0, n = 0; i < e.zero.size(); ++i) {
      if (e.zero[i]) rigid(static_cast<Eigen::Index>(n++)) = static_cast<double>(i + 1);
    }
    const std::string name = plain(e.name), p = plain(e.node_p), q = plain(e.node_q);
    const SceneBeam& b = e.beam;
    const bool planar = scene_.planar;
    switch (e.kind) {
      case Kind::truss:
        if (e.rigid()) {
          builder_.truss(name, p, q, {.rigid = true});
        } else {
          builder_.truss(
              name, p, q,
              {.stiffness = e.stiffness(0), .damping = e.damping(0), .preload = e.preload(0)});
        }
        break;
      case Kind::beam:
        builder_.beam(
            name, p, q,
            {.orientation = planar ? SceneDirection() : direction(b.orientation),
             .EA = unless_0(b.EA),
             .GJ = unless_0(b.GJ),
             .EI_y = unless_0(b.EI_y),
             .EI_z = planar ? std::nullopt : unless_0(b.EI_z),
             .EI = planar ? unless_0(b.EI_z) : std::nullopt,
             .shear_y = planar ? std::nullopt : unless_0(b.shear_y),
             .shear_z = unless_0(b.shear_z),
             .shear = planar ? unless_0(b.shear_y) : std::nullopt,
             .mass_per_length = b.mass_per_length,
             .inertia_per_length = planar ? std::nullopt : std::optional(b.inertia_per_length),
             .lumped_mass = b.lumped_mass,
             .second_order = b.second_order,
             .stiffness = e.stiffness,
             .damping = e.damping,
             .damping_time = unless_0(b.damping_time),
             .rigid = rigid,
             .preload = e.preload});
        break;
      case Kind::rigid_beam:
        builder_.rigid_beam(name, p, q);
        break;
      case Kind::superelement:
        builder_.superelement(name, e.superelement->nodes, e.superelement->files.front().path,
                              unless_0(e.superelement->damping_time));
        break;
      case Kind::hinge:
        builder_.hinge(name, p, q,
                       {.axis = planar ? SceneDirection() : direction(e.axis),
                        .rigid = rigid,
                        .stiffness = e.stiffness,
                        .damping = e.damping,
                        .preload = e.preload});
        break;
    }
  }
  void add_prescribed(const SceneConstraint& c) {
    const MotionKeys motion{.value = c.value, .rate = c.rate, .acceleration = c.acceleration};
    if (c.element.empty()) {
      builder_.prescribe(plain(c.node), directions(c), motion);
    } else {
      builder_.prescribe_element(plain(c.element), c.mode, motion);
    }
  }
  void add(const SceneDof& d) {
    const StartKeys start{.value = unless_0(d.value), .rate = unless_0(d.rate)};
    if (!d.element.empty()) {
      builder_.dof_of_element(plain(d.element), d.mode, start);
    } else if (d.direction) {
      builder_.dof_of_node(plain(d.node), direction(*d.direction), start);
    } else if (d.rotation) {
      builder_.dof_of_rotation(plain(d.node), start);
    } else {
      builder_.dof_of_euler_parameter(plain(d.node), d.euler_parameter, start);
    }
  }
  void add_signals() {
    const auto of = [](const SceneSignal& s) { return plain(s.node.empty() ? s.element : s.node); };
    const auto component = [&](const SceneSignal& s) -> SceneComponent {
      if (s.node.empty()) return s.mode;
      const bool none = scene_.planar && s.direction.z() != 0;
      return none ? SceneDirection() : direction(s.direction);
    };
    for (const auto& s : scene_.inputs) {
      builder_.input(s.name, s.quantity, of(s), component(s));
    }
    for (const auto& s : scene_.outputs) {
      builder_.output(s.name, s.quantity, of(s), component(s));
    }
    for (const auto& s : scene_.monitors) {
      builder_.monitor(s.name, s.quantity, of(s), component(s));
    }
  }
  void add(const SceneController& c) {
    ControllerKeys keys{
        .target_hz = Eigen::Map<const Eigen::VectorXd>(
            c.target_hz.data(), static_cast<Eigen::Index>(c.target_hz.size())),
        .damping_ratio = Eigen::Map<const Eigen::VectorXd>(
            c.damping_ratio.data(), static_cast<Eigen::Index>(c.damping_ratio.size())),
        .order = c.order,
        .reduction = c.reduction,
        .realisation = c.realisation,
        .sample_rate_hz = c.sample_rate_hz,
        .delay_samples = c.delay_samples,
        .leak_hz = c.leak_hz,
        .high_pass_hz = c.high_pass_hz,
        .lead_samples = c.lead_samples,
        .roll_off_hz = c.roll_off_hz,
        .force_limit_n = c.force_limit_n,
        .law = c.law ? c.law->file : ""};
    if (const auto& f = c.feed_forward) {
      keys.feed_forward = FeedForwardKeys{.to_hz = f->to_hz,
                                          .corner_hz = f->corner_hz,
                                          .target_hz = f->target_hz,
                                          .damping_ratio = f->damping_ratio,
                                          .at_most_db = f->at_most_db,
                                          .actuator_error = f->actuator_error,
                                          .noise_over_floor = f->noise_over_floor,
                                          .taps = f->taps};
    }
    for (const auto& leg : c.legs) keys.legs.push_back(plain(leg));
    builder_.controller(keys);
  }

  const Scene& scene_;
  SceneBuilder builder_;
};

TEST(SceneBuilder, MakesEveryScene) {
  int n_scenes = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(STILLFRAME_SOURCE_DIR) / "config/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().filename().string());
    ++n_scenes;
    const Scene read = read_scene(entry.path());
    const Rebuilt rebuilt(read);
    expect_same_scene(rebuilt.builder(), read);
  }
  EXPECT_GE(n_scenes, 20);
}

TEST(SceneBuilder, HasEveryKeyOfAController) {
  const std::string frame = shipped("metrology_frame.yaml").text;
  const ScratchFolder folder;
  const fs::path law = folder.write("gains.yaml", "K_P: [[1]]\nK_I: [[1]]\n");
  const std::string scene = frame.substr(0, frame.find("\ncontroller:"));
  const std::string start =
      "\ncontroller:\n  legs: [leg_1t, leg_1v]\n  target_hz: 5\n  damping_ratio: 0.7\n"
      "  sample_rate_hz: 1000\n  delay_samples: 1\n";
  const std::string designed =
      "  leak_hz: 0.05\n  order: deck\n  reduction: modes\n  realisation: naive_pi\n"
      "  high_pass_hz: 0.01\n  lead_samples: 1.5\n  roll_off_hz: 200\n  force_limit_n: 50\n";
  const std::string forward =
      "  feed_forward: {to_hz: 40, corner_hz: 0.7, target_hz: 4, damping_ratio: 0.8, at_most_db: "
      "-20, actuator_error: 0.03, noise_over_floor: 2e-3, taps: 9}\n";
  for (const std::string& rest :
       {designed + forward, designed + "  feed_forward: {}\n", "  law: " + law.string() + "\n"}) {
    const Scene read = parse_scene(scene + start + rest, "frame.yaml");
    ASSERT_TRUE(read.controller->feed_forward || read.controller->law);
    expect_same_scene(Rebuilt(read).builder(), read);
  }
}

TEST(SceneBuilder, KeepsEveryBitOfANumber) {
  std::mt19937_64 engine(1);
  const auto draw = [&] {
    for (;;) {
      const double value = std::bit_cast<double>(engine());
      if (std::abs(value) <= 1e30 && std::abs(value) >= 1e-30) return value;
    }
  };
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d position(draw(), draw(), draw());
    const double mass = std::abs(draw());
    const Scene scene =
        SceneBuilder("One mass").node("a", position).mass("a", mass).automatic_dofs().build();
    ASSERT_EQ(scene.nodes[0].position, position);
    ASSERT_EQ(scene.masses[0].mass, mass);
  }
}

TEST(SceneBuilder, HasATextThatAFileMayHold) {
  const Scene built = cart_builder().build(), read = parse_scene(built.text, "cart.yaml");
  EXPECT_EQ(account_of(read), account_of(built));
  EXPECT_EQ(read.hash, built.hash);
  EXPECT_EQ(read.text, built.text);
  EXPECT_NE(built.text.find(
                "\n  spring: {type: truss, nodes: [cart, mass], stiffness: 800, damping: 4}\n"),
            std::string::npos)
      << built.text;
}

TEST(SceneBuilder, TakesOtherBlocksAsTheyStandInAFile) {
  const Scene scene = cart_builder()
                          .output("floor", Quant::position, "cart", "x")
                          .block("compare", "x: {floor: floor, frame: x2}\n")
                          .block("simulation", R"(
duration_s: 12
relative_tolerance: 1e-7
)")
                          .build();
  ASSERT_EQ(scene.comparisons.size(), 1u);
  EXPECT_EQ(scene.comparisons[0].frame, "x2");
  EXPECT_EQ(scene.simulation.duration_s, 12);
  EXPECT_EQ(scene.simulation.relative_tolerance, 1e-7);
}

TEST(SceneBuilder, TakesNamesOfAllKinds) {
  for (const std::string name :
       {"null", "~",    "true", "1",  "-",  "- a", "a: b", "{a",   "#a", "it's", "\"",  "\\",
        " ",    "a\nb", "Füße", "*a", "&a", "!a",  "x",    "y, z", "[",  "% a",  "a #b"}) {
    const Scene scene = SceneBuilder(name)
                            .node(name, {0, 0, 0})
                            .node("other", {1, 0, 0})
                            .mass(name, 1)
                            .truss(name, name, "other", {.stiffness = 1})
                            .dof_of_element(name)
                            .load(name, {.force = {0, 0, 1}})
                            .output(name, Quant::stress, name)
                            .build();
    EXPECT_EQ(scene.title, name);
    EXPECT_EQ(scene.nodes[0].name, name);
    EXPECT_EQ(scene.masses[0].node, name);
    EXPECT_EQ(scene.elements[0].name, name);
    EXPECT_EQ(scene.elements[0].node_p, name);
    EXPECT_EQ(scene.dofs[0].element, name);
    EXPECT_EQ(scene.outputs[0].name, name);
  }
}

std::string refusal_of(const SceneBuilder& builder) {
  try {
    builder.build();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

struct BadCall {
  std::function<void(SceneBuilder&)> call;
  std::vector<std::string> parts;
};

/// A sound scene that a call spoils.
SceneBuilder sound_builder() {
  SceneBuilder builder("Swing");
  builder.node("a", {0, 0, 0})
      .node("b", {1, 0, 0})
      .node("c", {1, 0, 0})
      .mass("b", 2)
      .truss("leg", "a", "b", {.stiffness = 5})
      .support("a", {"x", "y", "z"})
      .support("b", {"y", "z"})
      .support("c", {"x", "y", "z"})
      .dof_of_element("leg")
      .input("push", Quant::force, "b", "x")
      .output("out", Quant::position, "b", "x");
  return builder;
}

TEST(SceneBuilder, RefusesWhatTheReaderRefuses) {
  ASSERT_EQ(refusal_of(sound_builder()), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const BeamKeys section{.orientation = "y", .EA = 1, .GJ = 1, .EI_y = 1, .EI_z = 1};
  const auto with_section = [&](const std::function<void(BeamKeys&)>& change) {
    BeamKeys keys = section;
    change(keys);
    return [keys](SceneBuilder& s) { s.beam("m", "a", "b", keys); };
  };
  const Eigen::Matrix3d indefinite{{1, 2, 0}, {2, 1, 0}, {0, 0, 1}};
  const Eigen::Matrix3d lopsided{{1, 0.1, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<BadCall> bad = {
      // Names.
      {[](SceneBuilder& s) {
         s.node("a", {2, 0, 0});
       },
       {"a: this key stands twice"}},
      {[](SceneBuilder& s) { s.truss("leg", "a", "c", {.stiffness = 1}); },
       {"elements.leg: this key stands twice"}},
      {[](SceneBuilder& s) {
         s.node("a/1", {2, 0, 0});
       },
       {"nodes.a/1: a '/' is reserved"}},
      {[](SceneBuilder& s) {
         s.node("\xff", {2, 0, 0});
       },
       {"found the byte 0xff"}},
      {[](SceneBuilder& s) { s.mass("bb", 1); },
       {"masses[2].node: there is no node named 'bb'; the nearest name is 'b'",
        ", in: - {node: bb, mass: 1}"}},
      {[](SceneBuilder& s) { s.truss("m", "a", "d", {.stiffness = 1}); },
       {"elements.m.nodes[2]: there is no node named 'd'",
        "in: m: {type: truss, nodes: [a, d], stiffness: 1}"}},
      {[](SceneBuilder& s) { s.dof_of_element("lge"); }, {"there is no element named 'lge'"}},
      {[](SceneBuilder& s) { s.output("out", Quant::stress, "leg"); }, {"'out' is used twice"}},
      {[](SceneBuilder& s) { s.monitor("out", Quant::stress, "leg"); }, {"'out' is used twice"}},
      {[](SceneBuilder& s) { s.input("", Quant::stress, "leg"); }, {"inputs[2].name: found ''"}},
      // Given twice, or not at all.
      {[](SceneBuilder& s) {
         s.gravity({0, 0, 1}).gravity({0, 0, 1});
       },
       {"gravity: this key stands twice"}},
      {[](SceneBuilder& s) { s.automatic_dofs(); }, {"dofs: this key stands twice"}},
      {[](SceneBuilder& s) { s.block("nodes", "{}"); }, {"nodes: this key stands twice"}},
      {[](SceneBuilder& s) { s = SceneBuilder(""); }, {"title: found '', allowed is a word"}},
      {[](SceneBuilder& s) { s = SceneBuilder("Empty"); }, {"the key 'nodes' is missing"}},
      {[](SceneBuilder& s) {
         s = SceneBuilder("No dofs").node("a", {0, 0, 0});
       },
       {":1:1: the key 'dofs' is missing, in: title: \"No dofs\""}},
      {[](SceneBuilder& s) { s = SceneBuilder("Nowhere").node("a", {}).automatic_dofs(); },
       {"nodes.a: the key 'position' is missing"}},
      {[](SceneBuilder& s) { s.block("florr", "{}"); }, {"florr: unknown key (did you mean"}},
      {[](SceneBuilder& s) { s.block("floor", "a: b: c"); }, {"not YAML"}},
      // Numbers.
      {[&](SceneBuilder& s) {
         s.node("d", {nan, 0, 0});
       },
       {"nodes.d.position[1]: found 'nan', allowed is a finite number"}},
      {[&](SceneBuilder& s) {
         s.node("d", {infinity, 0, 0});
       },
       {"position[1]: found 'inf'"}},
      {[](SceneBuilder& s) {
         s.node("d", {1e31, 0, 0});
       },
       {"a number from -1e+30 to 1e+30"}},
      {[](SceneBuilder& s) {
         s.node("d", {0, 0});
       },
       {"nodes.d.position: found a sequence of 2, allowed is a sequence of 3 numbers"}},
      {[](SceneBuilder& s) {
         s.node("d", {0, 0, 1}).planar();
       },
       {"but the scene is planar"}},
      {[](SceneBuilder& s) { s.mass("b", -2); },
       {"masses[2].mass: found '-2', allowed is a number that is not negative",
        ", in: - {node: b, mass: -2}"}},
      {[](SceneBuilder& s) {
         s.mass("b", 2, {1, 1, 3});
       },
       {"no body has these principal"}},
      {[&](SceneBuilder& s) { s.mass("b", 2, lopsided); }, {"inertia matrix is not symmetric"}},
      {[](SceneBuilder& s) { s.mass("b", 2, 3); }, {"masses[2].inertia: found"}},
      // Elements.
      {[](SceneBuilder& s) { s.truss("m", "a", "b", {}); }, {"a truss needs a stiffness"}},
      {[](SceneBuilder& s) { s.truss("m", "a", "b", {.stiffness = -1}); },
       {"elements.m.stiffness: found '-1', allowed is a number that is not negative"}},
      {[](SceneBuilder& s) { s.truss("m", "a", "b", {.damping = 1, .rigid = true}); },
       {"elements.m.damping: a rigid element has none"}},
      {[](SceneBuilder& s) { s.truss("m", "b", "c", {.stiffness = 1}); }, {"zero length"}},
      {[](SceneBuilder& s) { s.rigid_beam("m", "b", "c"); }, {"zero length"}},
      {[](SceneBuilder& s) { s.hinge("m", "a", "b", {.axis = "x"}); }, {"1 m apart"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c"); }, {"elements.m: the key 'axis' is missing"}},
      {[](SceneBuilder& s) {
         s.hinge("m", "b", "c", {.axis = {0, 0, 0}});
       },
       {"a direction cannot be zero"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c", {.axis = "w"}); },
       {"elements.m.axis: found 'w', allowed is one of x, y, z"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c", {.axis = "x", .rigid = {4}}); },
       {"found 4, allowed is 1 to 3"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c", {.axis = "x", .rigid = {1.5}}); },
       {"found '1.5', allowed is a whole number"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c", {.axis = "x", .rigid = {1}, .ball = true}); },
       {"elements.m.rigid: this key stands twice"}},
      {[&](SceneBuilder& s) {
         s.hinge("m", "b", "c", {.axis = "x", .ball = true, .stiffness = indefinite});
       },
       {"elements.m.stiffness: the stiffness matrix is indefinite"}},
      {[&](SceneBuilder& s) {
         s.hinge("m", "b", "c", {.axis = "x", .ball = true, .damping = indefinite});
       },
       {"elements.m.damping: the damping matrix is indefinite"}},
      {[](SceneBuilder& s) {
         s.hinge("m", "b", "c", {.axis = "x", .stiffness = {1, 1, 0}});
       },
       {"deformation 2 is rigid, its numbers must be 0"}},
      {[](SceneBuilder& s) { s.hinge("m", "b", "c", {.axis = "x", .stiffness = {3}}); },
       {"elements.m.stiffness: found a sequence of 1, allowed is a sequence of 3 numbers"}},
      {[](SceneBuilder& s) { s.controller({}).block("controller", "{}"); },
       {"controller: this key stands twice"}},
      {[](SceneBuilder& s) { s.block("controller", "nowhere.yaml"); },
       {"controller: the file 'nowhere.yaml' does not exist, in: nowhere.yaml"}},
      {with_section([](BeamKeys& keys) { keys.EA = {}; }), {"elements.m: the key 'EA' is missing"}},
      {with_section([](BeamKeys& keys) { keys.EA = 0; }), {"elements.m.EA: found '0'"}},
      {with_section([](BeamKeys& keys) { keys.EI = 1; }), {"elements.m.EI: a spatial beam has"}},
      {with_section([](BeamKeys& keys) { keys.orientation = {}; }), {"needs an orientation"}},
      {with_section([](BeamKeys& keys) { keys.orientation = "x"; }), {"parallel to the beam"}},
      {with_section([](BeamKeys& keys) {
         keys.preload = {1, 2, 3};
       }),
       {"elements.m.preload: found a sequence of 3, allowed is a sequence of 6 numbers"}},
      {with_section([](BeamKeys& keys) { keys.stiffness = Eigen::MatrixXd::Identity(5, 5); }),
       {"elements.m.stiffness: found a sequence of 5, allowed is 6 rows of 6 numbers"}},
      {with_section([](BeamKeys& keys) { keys.mass_per_length = -1; }), {"not negative"}},
      {with_section([](BeamKeys& keys) { keys.divide = 0; }), {"elements.m.divide: found '0'"}},
      // What refers to them.
      {[](SceneBuilder& s) { s.support("b", {"w"}); }, {"supports[4].fix[1]: found 'w'"}},
      {[](SceneBuilder& s) { s.prescribe("b", {"rotation"}); }, {"only a planar scene"}},
      {[](SceneBuilder& s) { s.prescribe_element("leg", 2); }, {"'leg' has 1 deformation"}},
      {[](SceneBuilder& s) { s.prescribe_element("leg", 0); }, {"prescribed[1].mode: found '0'"}},
      {[](SceneBuilder& s) { s.dof_of_element("leg", 1, {.value = 1}); },
       {"dofs[2].value: needs operating_point: as_written"}},
      {[](SceneBuilder& s) { s.dof_of_rotation("b"); }, {"is for planar scenes"}},
      {[](SceneBuilder& s) { s.dof_of_euler_parameter("b", 4); }, {"one of 0, 1, 2, 3"}},
      {[](SceneBuilder& s) { s.load("b", {}); }, {"a load needs a 'force' or a 'torque'"}},
      {[](SceneBuilder& s) { s.input("i", Quant::acceleration, "b"); }, {"'along' (a direction)"}},
      {[](SceneBuilder& s) { s.input("i", Quant::reaction, "b", "x"); }, {"reaction: unknown key"}},
      {[](SceneBuilder& s) { s.output("o", Quant::force, "b", "x"); }, {"force: unknown key"}},
      {[](SceneBuilder& s) { s.output("o", Quant::stress, "leg", 2); },
       {"'leg' has 1 deformation"}},
      {[](SceneBuilder& s) { s.output("o", Quant::stress, "leg", "x"); }, {"has no direction"}},
      {[](SceneBuilder& s) {
         s.controller({.legs = {"leg"}, .target_hz = 5, .damping_ratio = 0.7, .leak_hz = 0});
       },
       {"controller: the key 'sample_rate_hz' is missing"}},
      {[](SceneBuilder& s) { s.controller({}); }, {"controller.legs: at least one leg"}},
  };
  for (const BadCall& each : bad) {
    SceneBuilder builder = sound_builder();
    each.call(builder);
    const std::string message = refusal_of(builder);
    EXPECT_EQ(message.find('\xff'), std::string::npos);
    EXPECT_TRUE(message.starts_with("scene builder:")) << each.parts[0] << "\n" << message;
    for (const std::string& part : each.parts) {
      EXPECT_NE(message.find(part), std::string::npos)
          << "message: " << message << "\nlacks:   " << part;
    }
  }
}

TEST(SceneBuilder, SaysWhatAFileThatABlockNamesHasWrong) {
  const ScratchFolder folder;
  const fs::path file = folder.write("law.yaml", "legs: [leg]\ntarget_hz: -5\n");
  SceneBuilder builder = sound_builder();
  const std::string message = refusal_of(builder.block("controller", file.string()));
  EXPECT_EQ(
      message,
      file.string() + ":2:12: target_hz: found '-5', allowed is a number above 0 and up to 1e+06");
}

}  // namespace
}  // namespace stillframe::test

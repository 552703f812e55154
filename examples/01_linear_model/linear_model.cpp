// A scene to A, B, C and D: a mass of 2 kg on a spring and damper, on a cart whose acceleration is
// the input.
#include <iostream>
#include <stillframe.hpp>

int main() {
  const stillframe::Scene scene = stillframe::parse_scene(R"(
title: Mass on a cart
nodes:
  cart: {position: [0, 0, 0]}
  mass: {position: [1, 0, 0]}
masses: [{node: mass, mass: 2}]
elements:
  spring: {type: truss, nodes: [cart, mass], stiffness: 800, damping: 4}
supports: [{nodes: [cart, mass], fix: [y, z]}]
prescribed: [{nodes: [cart], move: [x]}]
dofs: [{element: spring}]
inputs: [{name: cart, acceleration: cart, along: x}]
outputs: [{name: mass, acceleration: mass, along: x}]
)",
                                                          "cart");
  const stillframe::Model model = stillframe::make_model(scene);
  const auto linear = stillframe::linearise(model, scene.inputs, scene.outputs);
  const stillframe::StateSpace G = stillframe::state_space(linear);
  // B and D have three columns for a motion: its acceleration, velocity and position.
  std::cout << "A\n" << G.A << "\nB\n" << G.B << "\nC\n" << G.C << "\nD\n" << G.D << "\n";
}

#pragma once

#include <string>

namespace stillframe::test {

/// A planar table of 180 kg on two feet, fl and fr, and a third one beside it, fs, with its mass c
/// at x (m): the scene without signals, loop and floor. Its legs are left, right and side.
inline std::string three_feet(const std::string& x) {
  return R"(title: Three feet
planar: true
nodes: {fl: {position: [-0.6, 0]}, fr: {position: [0.6, 0]}, fs: {position: [-0.9, 0.25]},
  pl: {position: [-0.6, 0.25]}, pr: {position: [0.6, 0.25]}, c: {position: [)" +
         x + R"(, 0.25]}}
masses: [{node: c, mass: 180, inertia: 25}]
elements:
  left: {type: truss, nodes: [fl, pl], stiffness: 2e6, damping: 150}
  right: {type: truss, nodes: [fr, pr], stiffness: 2e6, damping: 150}
  side: {type: truss, nodes: [fs, pl], stiffness: 1e6, damping: 100}
  arm_l: {type: rigid_beam, nodes: [c, pl]}
  arm_r: {type: rigid_beam, nodes: [c, pr]}
prescribed: [{nodes: [fl, fr, fs], move: [x, y]}]
dofs: [{element: left}, {element: right}, {element: side}]
outputs: [{name: c_x, acceleration: c, along: x}, {name: c_y, acceleration: c, along: y}]
compare: {x: {floor: g_x, frame: c_x}, y: {floor: g_y, frame: c_y}}
)";
}

}  // namespace stillframe::test

#pragma once

// Scenes for the tests of the reader.
namespace stillframe::test {

/// A spatial scene with every key of the structure. It is read, not modelled: its parts do not fit.
inline const char* const every_spatial_key = R"(title: Crane
gravity: [0, 0, -9.81]
nodes:
  foot: {position: [0, 0, 0]}
  top: {position: [0, 0, 1]}
  jib: {position: [0, 0, 1]}
  tip: {position: [3, 0.5, 1]}
  anchor: {position: [2, 0, 0]}
masses:
  - {node: tip, mass: 2, inertia: [1, 2, 3]}
  - {node: boom/1, mass: 0.5}
elements:
  mast: {type: beam, nodes: [foot, top], orientation: [0, 2, 0], EA: 1e7, GJ: 2e4, EI_y: 3e4,
    EI_z: 4e4, shear_y: 5e6, shear_z: 6e6, mass_per_length: 7, inertia_per_length: 0.08,
    mass: lumped, second_order: true, damping_time: 1e-3, preload: [-20, 0, 0, 0, 0, 1]}
  pivot: {type: hinge, nodes: [top, jib], axis: [0, 3, 0], stiffness: 100, damping: 2, preload: 5}
  boom: {type: beam, nodes: [jib, tip], orientation: z, rigid: [2, 1], EI_y: 1e4, EI_z: 1e4,
    divide: 4, preload: [0, 0, 1, 2, 3, 4]}
  rod: {type: beam, nodes: [tip, anchor], orientation: y, rigid: true, mass_per_length: 2}
  ball: {type: hinge, nodes: [top, jib], axis: x, rigid: [], stiffness: [1, 2, 3],
    damping: [[2, 1, 0], [1, 2, 0], [0, 0, 0]], preload: [1, 2, 3]}
  wrist: {type: hinge, nodes: [top, jib], axis: z, rigid: [1, 3], stiffness: 7, preload: 5}
  cable: {type: truss, nodes: [anchor, tip], stiffness: 1e5, damping: 3, preload: 40}
  stay: {type: truss, nodes: [anchor, top], rigid: true}
  arm: {type: rigid_beam, nodes: [foot, anchor]}
supports:
  - {nodes: [foot, anchor], fix: [x, [0, 3, 4], rotation]}
prescribed:
  - {nodes: [foot, anchor], move: [z, x], value: 0.1, rate: 0.2, acceleration: 0.3}
  - {element: pivot, rate: 10}
  - {element: boom/2, mode: 6}
dofs:
  - {deformations: mast}
  - {deformations: [boom, pivot]}
  - {element: cable}
  - {element: pivot}
  - {element: ball, mode: 3}
  - {element: boom/4, mode: 5}
  - {node: tip, along: [0, 0, -2]}
  - {node: tip, euler_parameter: 0}
loads:
  - {node: tip, force: [1, 2, 3], torque: [4, 5, 6], follows: true}
  - {node: top, torque: [0, 0, 1]}
inputs:
  - {name: i1, acceleration: foot, along: z}
  - {name: i2, torque: tip, along: [2, 0, 0]}
  - {name: i3, stress: boom/1, mode: 4}
  - {name: i4, deformation_rate: pivot}
outputs:
  - {name: o1, reaction: foot, along: x}
  - {name: o2, reaction_moment: foot, along: y}
  - {name: o3, angular_velocity: tip, along: z}
  - {name: o4, deformation_acceleration: mast, mode: 2}
  - {name: o5, position: boom/3, along: z}
)";

/// The same in the plane.
inline const char* const every_planar_key = R"(title: Slider and crank
planar: true
gravity: [0, -9.81]
modal_damping: [[1, 0.02], [30, 0.01]]
operating_point: as_written
nodes:
  ground: {position: [0, 0]}
  crank: {position: [0, 0, 0]}
  pin: {position: [0.3, 0]}
  rod: {position: [0.3, 0]}
  slider: {position: [1, 0]}
masses:
  - {node: slider, mass: 2, inertia: 0.3}
elements:
  motor: {type: hinge, nodes: [ground, crank]}
  arm: {type: rigid_beam, nodes: [crank, pin]}
  knee: {type: hinge, nodes: [pin, rod], stiffness: 4, damping: [[5]], preload: [6]}
  link: {type: beam, nodes: [rod, slider], EA: 1e6, EI: 20, shear: 3e5, mass_per_length: 0.4}
supports:
  - {nodes: [ground], fix: [x, y, rotation]}
  - {nodes: [slider], fix: [y]}
prescribed:
  - {element: motor, value: 0.1, rate: 10, acceleration: -1}
  - {nodes: [ground], move: [rotation, [1, 1]]}
dofs:
  - {element: link, mode: 2, value: 1e-3, rate: -2e-3}
  - {node: slider, rotation: true}
loads:
  - {node: slider, force: [1, 2], torque: 3}
inputs:
  - {name: turn, angular_acceleration: ground}
outputs:
  - {name: moment, reaction_moment: ground}
  - {name: place, position: slider, along: [3, 4]}
)";

}  // namespace stillframe::test

#pragma once

#include <string>
#include <vector>

#include "tests/core/bad_scenes.hpp"

// A sound planar scene, and what a person may get wrong in it.
namespace stillframe::test {

/// A motor turns a crank, an elastic rod moves a slider.
inline const std::string sound_crank = R"(title: Slider and crank
planar: true
gravity: [0, 0]
operating_point: as_written
nodes:
  ground: {position: [0, 0]}
  crank: {position: [0, 0]}
  pin: {position: [0.3, 0]}
  rod: {position: [0.3, 0]}
  slider: {position: [1, 0]}
masses:
  - {node: slider, mass: 2, inertia: 0.3}
elements:
  motor: {type: hinge, nodes: [ground, crank]}
  arm: {type: rigid_beam, nodes: [crank, pin]}
  knee: {type: hinge, nodes: [pin, rod]}
  link: {type: beam, nodes: [rod, slider], EA: 1e6, EI: 20, mass_per_length: 0.4}
supports:
  - {nodes: [ground], fix: [x, y, rotation]}
  - {nodes: [slider], fix: [y]}
prescribed:
  - {element: motor, rate: 10}
dofs:
  - {element: link, mode: 1}
  - {element: link, mode: 2, value: 1e-5}
  - {element: link, mode: 3}
inputs:
  - {name: turn, deformation_acceleration: motor}
outputs:
  - {name: slide, position: slider, along: x}
  - {name: tilt, rotation: slider}
)";

inline const std::vector<BadScene> bad_planar_scenes = {
    {"planar_word", "planar: true", "planar: 1", "1\n", {"planar: found '1', allowed is true"}},
    {"spatial_position",
     "[0.3, 0]",
     "[0.3, 0, 0.25]",
     "[0.3",
     {"nodes.pin.position: found z = 0.25, but the scene is planar"}},
    {"position_of_one_number",
     "[0.3, 0]",
     "[0.3]",
     "[0.3",
     {"nodes.pin.position: found 1 numbers, allowed in a planar scene are two"}},
    {"gravity_out_of_the_plane",
     "gravity: [0, 0]",
     "gravity: [0, 0, -9.81]",
     "[0, 0, -9.81]",
     {"gravity: found z = -9.81, but the scene is planar"}},
    {"direction_out_of_the_plane",
     "fix: [y]",
     "fix: [z]",
     "z]",
     {"supports[2].fix[1]: found 'z', allowed is one of x, y"}},
    {"zero_planar_direction",
     "along: x",
     "along: [0, 0]",
     "[0, 0]}\n  - {name: tilt",
     {"outputs[1].along: a direction cannot be zero"}},
    {"three_moments",
     "inertia: 0.3",
     "inertia: [0.3, 0.3, 0.3]",
     "[0.3, 0.3",
     {"masses[1].inertia: allowed in a planar scene is one number"}},
    {"negative_moment",
     "inertia: 0.3",
     "inertia: -0.3",
     "-0.3",
     {"masses[1].inertia: found '-0.3'", "not negative"}},
    {"orientation_in_the_plane",
     "EA: 1e6",
     "orientation: y, EA: 1e6",
     "y, EA",
     {"elements.link.orientation: a beam of a planar scene has none"}},
    {"spatial_key_of_a_planar_beam",
     "EI: 20",
     "EI_z: 20",
     "EI_z",
     {"elements.link.EI_z: unknown key", "did you mean 'EI'?", "allowed: type, nodes, EA, EI"}},
    {"no_planar_stiffness",
     ", EI: 20",
     "",
     "{type: beam",
     {"elements.link: the key 'EI' is missing (the stiffness of deformations 2 and 3)"}},
    {"rigid_deformation_of_a_planar_beam",
     "EI: 20",
     "EI: 20, rigid: [4]",
     "4]",
     {"elements.link.rigid[1]: found 4, allowed is 1 to 3"}},
    {"axis_in_the_plane",
     "nodes: [pin, rod]",
     "nodes: [pin, rod], axis: z",
     "z}",
     {"elements.knee.axis: a hinge of a planar scene turns about z and has none"}},
    {"mode_of_a_planar_hinge",
     "element: motor",
     "element: motor, mode: 2",
     "2, rate",
     {"prescribed[1].mode: found 2, but 'motor' has 1 deformation"}},
    {"euler_parameter_in_the_plane",
     "{element: link, mode: 1}",
     "{node: rod, euler_parameter: 2}",
     "2}\n",
     {"dofs[1].euler_parameter: a planar scene has none, write rotation: true"}},
    {"dof_of_a_planar_node_alone",
     "{element: link, mode: 1}",
     "{node: rod}",
     "{node: rod}",
     {"dofs[1]: a dof of a node needs either 'along' or 'rotation: true'"}},
    {"rotation_that_is_none",
     "{element: link, mode: 1}",
     "{node: rod, rotation: false}",
     "false",
     {"dofs[1].rotation: found 'false', allowed is one of true"}},
    {"planar_rotation_with_direction",
     "rotation: slider",
     "rotation: slider, along: y",
     "y}\n",
     {"outputs[2].along: a planar scene turns about z and needs none"}},
    {"torque_with_three_numbers",
     "inputs:",
     "loads:\n  - {node: slider, torque: [0, 0, 7]}\ninputs:",
     "[0, 0, 7]",
     {"loads[1].torque: found a sequence of 3, allowed is a finite number"}},
    {"value_of_deformations",
     "{element: link, mode: 1}",
     "{deformations: link, value: 0.5}",
     "0.5",
     {"dofs[1].value: belongs to a single dof, not to 'deformations'"}},
};

}  // namespace stillframe::test

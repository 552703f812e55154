#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "tests/closed_loop/workspace.hpp"

namespace stillframe::test {

/// Verbs that do not run anything: text in, text out.
class Verb : public Workspace {
 protected:
  nlohmann::json json(std::vector<std::string> arguments, int exit_code = 0) const {
    arguments.push_back("--json");
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, exit_code) << said.error;
    EXPECT_EQ(said.error, "");
    return nlohmann::json::parse(said.output);
  }

  void expect_refused(const std::vector<std::string>& arguments, int code,
                      const std::string& message) const {
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, code) << said.error;
    EXPECT_EQ(said.output, "");
    EXPECT_NE(said.error.find(message), std::string::npos) << said.error;
  }

  /// Every key that a verb prints stands in its --help.
  void expect_documented_keys(const std::string& verb, const nlohmann::json& document) const {
    const std::string help = run({verb, "--help"}).output;
    for (const auto& [key, value] : document.items()) {
      EXPECT_NE(help.find(key), std::string::npos) << verb << " --help has no word on " << key;
    }
  }
};

inline Eigen::MatrixXd matrix_of(const nlohmann::json& rows, Eigen::Index n_columns) {
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), n_columns);
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t j = 0; j < rows[i].size(); ++j) {
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
    }
  }
  return matrix;
}

/// Forty beams in a row, clamped at a: 280 coordinates, many enough for the sparse way.
inline std::string large_chain(const std::string& rest) {
  return R"(title: chain
nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
masses: [{node: b, mass: 0.2}]
elements:
  beam: {type: beam, nodes: [a, b], EA: 2.1e7, GJ: 112, EI_y: 174.3, EI_z: 252, orientation: [0, 1, 0],
    mass_per_length: 0.78, inertia_per_length: 1.5834e-5, damping_time: 1e-5, divide: 40}
dofs: auto
supports: [{nodes: [a], fix: [x, y, z, rotation]}]
)" + rest;
}

/// A mass of 2 kg that hangs on a spring of 800 N/m.
inline const char* hanging_mass = R"(title: A hanging mass
gravity: [0, 0, -9.81]
nodes:
  ceiling: {position: [0, 0, 1]}
  mass: {position: [0, 0, 0]}
masses:
  - {node: mass, mass: 2}
elements:
  spring: {type: truss, nodes: [ceiling, mass], stiffness: 800, damping: 4}
supports:
  - {nodes: [ceiling], fix: [x, y, z]}
  - {nodes: [mass], fix: [x, y]}
dofs:
  - {element: spring}
inputs:
  - {name: push, force: mass, along: z}
outputs:
  - {name: height, position: mass, along: z}
)";

}  // namespace stillframe::test

#include "core/systems/state_space_model.hpp"

#include <stdexcept>

namespace stillframe {

namespace {

using Eigen::Index;

void require(bool fits, const std::string& what, Index expected, Index got) {
  if (fits) return;
  throw std::invalid_argument("state space: " + what + ": expected " + std::to_string(expected) +
                              ", got " + std::to_string(got));
}

void require_names(const std::vector<SignalName>& names, const std::string& what, Index expected) {
  const auto n = static_cast<Index>(names.size());
  require(n == 0 || n == expected, "names of " + what, expected, n);
}

void require_point(const Eigen::VectorXd& point, const std::string& what, Index expected) {
  require(point.size() == 0 || point.size() == expected, what, expected, point.size());
}

}  // namespace

StateSpace proper_system(const LinearSystem& system) {
  StateSpace out;
  out.A = system.A;
  out.B = system.B;
  out.C = system.C;
  out.D = system.D;
  for (Index j = 0; j < system.B.cols(); ++j) {
    out.columns.push_back({InputColumns::Kind::direct, j});
  }
  return out;
}

void check_shapes(const StateSpace& system) {
  const Index n = system.A.rows(), n_columns = system.B.cols(), p = system.C.rows();
  require(system.A.cols() == n, "columns of A", n, system.A.cols());
  require(system.B.rows() == n, "rows of B", n, system.B.rows());
  require(system.C.cols() == n, "columns of C", n, system.C.cols());
  require(system.D.rows() == p, "rows of D", p, system.D.rows());
  require(system.D.cols() == n_columns, "columns of D", n_columns, system.D.cols());
  for (const InputColumns& input : system.columns) {
    const Index end = input.first + input.width();
    require(input.first >= 0, "first column of an input", 0, input.first);
    require(end <= n_columns, "columns of B for the inputs", end, n_columns);
  }
  const auto m = static_cast<Index>(system.columns.size());
  require_names(system.inputs, "inputs", m);
  require_names(system.outputs, "outputs", p);
  require_names(system.states, "states", n);
  require_point(system.x0, "x0", n);
  require_point(system.u0, "u0", m);
  require_point(system.y0, "y0", p);
}

}  // namespace stillframe

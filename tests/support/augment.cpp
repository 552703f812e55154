#include "tests/support/augment.hpp"

#include <stdexcept>

namespace stillframe::test {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Kind = InputColumns::Kind;

bool acts(const StateSpace& system, Index column) {
  return !system.B.col(column).isZero(0) || !system.D.col(column).isZero(0);
}

/// What one input becomes: the column that it drives itself, and the columns that its integrals
/// drive, the first integral first.
struct Chain {
  Index direct = 0;
  Index n_integrals = 0;
};

Chain chain_of(const StateSpace& system, size_t j) {
  const InputColumns& input = system.columns[j];
  if (input.kind == Kind::direct) return {input.first, 0};
  const Index own = input.kind == Kind::acceleration ? 0 : input.kind == Kind::velocity ? 1 : 2;
  for (Index order = 0; order < own; ++order) {
    if (!acts(system, input.first + order)) continue;
    const std::string name = j < system.inputs.size() ? " '" + system.inputs[j].name + "'" : "";
    throw std::invalid_argument("augmented: input" + name +
                                " acts by a derivative of itself; give it as " +
                                (order == 0 ? "an acceleration" : "a velocity"));
  }
  Chain chain{input.first + own, 0};
  for (Index integral = 1; own + integral < 3; ++integral) {
    if (acts(system, chain.direct + integral)) chain.n_integrals = integral;
  }
  return chain;
}

SignalName integral_name(const StateSpace& system, size_t j, Index integral) {
  const std::string name = j < system.inputs.size() ? system.inputs[j].name : "";
  const bool velocity = system.columns[j].kind == Kind::acceleration && integral == 1;
  return {name + (velocity ? " velocity" : " position"), velocity ? "m/s" : "m"};
}

}  // namespace

StateSpace augmented(const StateSpace& system) {
  check_shapes(system);
  const size_t m = system.columns.size();
  std::vector<Chain> chains;
  Index n_added = 0;
  for (size_t j = 0; j < m; ++j) {
    chains.push_back(chain_of(system, j));
    n_added += chains.back().n_integrals;
  }
  const Index n = system.A.rows(), total = n + n_added, p = system.C.rows();
  const auto n_inputs = static_cast<Index>(m);
  StateSpace out{.A = MatrixXd::Zero(total, total),
                 .B = MatrixXd::Zero(total, n_inputs),
                 .C = MatrixXd::Zero(p, total),
                 .D = MatrixXd::Zero(p, n_inputs),
                 .columns = {},
                 .inputs = system.inputs,
                 .outputs = system.outputs,
                 .states = system.states,
                 .x0 = system.x0,
                 .u0 = system.u0,
                 .y0 = system.y0};
  out.A.topLeftCorner(n, n) = system.A;
  out.C.leftCols(n) = system.C;
  Index state = n;
  for (size_t j = 0; j < m; ++j) {
    const auto column = static_cast<Index>(j);
    out.columns.push_back({Kind::direct, column});
    out.B.col(column).head(n) = system.B.col(chains[j].direct);
    out.D.col(column) = system.D.col(chains[j].direct);
    for (Index integral = 1; integral <= chains[j].n_integrals; ++integral, ++state) {
      // The first integral is driven by the input, the second by the first.
      (integral == 1 ? out.B(state, column) : out.A(state, state - 1)) = 1.0;
      out.A.col(state).head(n) = system.B.col(chains[j].direct + integral);
      out.C.col(state) = system.D.col(chains[j].direct + integral);
      if (!system.states.empty()) out.states.push_back(integral_name(system, j, integral));
    }
  }
  // The operating point is kept where it can be: the added motions are counted from it.
  if (out.x0.size() > 0) out.x0.conservativeResizeLike(Eigen::VectorXd::Zero(total));
  return out;
}

}  // namespace stillframe::test

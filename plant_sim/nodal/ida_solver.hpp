#pragma once

#include <memory>

#include "plant_sim/nodal/equations.hpp"
#include "plant_sim/nodal/status.hpp"

namespace stillframe::nodal {

/// SUNDIALS IDA, variable-order backward differentiation formulas, on the equations in nodal
/// coordinates as a differential-algebraic system of index 1,
///   x' - v = 0, and Equations::residual with x'' = v',
/// with analytic Jacobian. Set-up: construction. hot: noexcept; SUNDIALS allocates its work space
/// at the first call.
class IdaSolver {
 public:
  /// equations must outlive this. Errors: std::runtime_error if SUNDIALS cannot be set up.
  IdaSolver(Equations& equations, double relative_tolerance);
  ~IdaSolver();
  IdaSolver(const IdaSolver&) = delete;
  IdaSolver& operator=(const IdaSolver&) = delete;

  /// Moves a consistent state on by a duration (s), from t = 0 of the inputs. Local errors are kept
  /// below the relative tolerance times the larger of the change since the start and the scale.
  Status advance(NodalState& state, const Inputs& inputs, double duration,
                 const ErrorScale& scale) noexcept;

  /// Residuals evaluated and steps made since construction.
  long evaluations() const noexcept;
  long steps() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillframe::nodal

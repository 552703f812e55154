#include "plant_sim/nodal/ida_solver.hpp"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace stillframe::nodal {

namespace {

constexpr int max_steps = 100'000;  // within one part

using Map = Eigen::Map<Eigen::VectorXd>;

Map view(N_Vector vector) { return {N_VGetArrayPointer(vector), N_VGetLength(vector)}; }

void check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("SUNDIALS: ") + what + " failed");
}

}  // namespace

/// y = (change of the free x since the start, the same of x', lambda). SUNDIALS sees the Jacobian
/// only as something that the linear solver knows how to factorise and solve with.
struct IdaSolver::Impl {
  Equations& equations;
  double relative_tolerance;
  const Inputs* inputs = nullptr;
  NodalState state;
  Factors<double> factors;
  Eigen::VectorXd x_start, v_start, r;
  ErrorScale scale;
  double gamma = 0;  ///< s, 1 / c_j of the present factors
  long steps = 0, evaluations = 0;
  SUNContext context = nullptr;
  N_Vector y = nullptr, y_dot = nullptr, id = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  void* memory = nullptr;

  Impl(Equations& e, double tolerance)
      : equations(e),
        relative_tolerance(tolerance),
        state(e.zero_state()),
        factors(e.factors<double>()),
        r(e.size()) {}
  ~Impl() {
    if (memory) IDAFree(&memory);
    if (solver) SUNLinSolFreeEmpty(solver);
    if (matrix) SUNMatFreeEmpty(matrix);
    for (N_Vector vector : {y, y_dot, id}) {
      if (vector) N_VDestroy(vector);
    }
    if (context) SUNContext_Free(&context);
  }

  Index n() const noexcept { return equations.n_free(); }
  Index n_held() const noexcept { return equations.n_held(); }

  void set_state(double t, const Map& at, const Map& rate) noexcept {
    state.x.head(n()) = x_start + at.head(n());
    state.x_dot.head(n()) = v_start + at.segment(n(), n());
    state.x_ddot.head(n()) = rate.segment(n(), n());
    state.lambda = at.tail(n_held());
    equations.take_inputs(*inputs, t, state);
  }

  static int residual(realtype t, N_Vector y, N_Vector y_dot, N_Vector result,
                      void* user) noexcept {
    auto& self = *static_cast<Impl*>(user);
    const Map rate = view(y_dot);
    self.set_state(t, view(y), rate);
    ++self.evaluations;
    self.equations.residual(self.state, self.r);
    Map out = view(result);
    out.head(self.n()) = rate.head(self.n()) - self.state.x_dot.head(self.n());
    out.tail(self.r.size()) = self.r;
    // Positive: recoverable, SUNDIALS tries a smaller step before it gives up.
    return out.allFinite() ? 0 : 1;
  }

  static int jacobian(realtype t, realtype c_j, N_Vector y, N_Vector y_dot, N_Vector, SUNMatrix,
                      void* user, N_Vector, N_Vector, N_Vector) noexcept {
    auto& self = *static_cast<Impl*>(user);
    self.set_state(t, view(y), view(y_dot));
    self.equations.differentiate(self.state, true);
    self.gamma = 1 / c_j;
    return 0;
  }

  static int factorise(SUNLinearSolver solver, SUNMatrix) noexcept {
    auto& self = *static_cast<Impl*>(solver->content);
    return self.equations.factorise(self.factors, self.gamma) ? 0 : 1;
  }

  /// [c 1, -1, 0; K, c M + C, D^T; G_x, c D + G_v, 0] (dx, dv, dlambda) = (b_1, b_2), with
  /// dx = gamma (b_1 + dv) taken out and the rest divided by c.
  static int solve(SUNLinearSolver solver, SUNMatrix, N_Vector result, N_Vector right,
                   realtype) noexcept {
    auto& self = *static_cast<Impl*>(solver->content);
    const Index n = self.n();
    const double gamma = self.gamma;
    Map b = view(right), d = view(result);
    self.r = gamma * b.tail(self.r.size());
    d.head(n) = gamma * gamma * b.head(n);
    if (!b.head(n).isZero(0)) self.equations.add_stiffness_product(-1, d.head(n), self.r);
    self.equations.solve(self.factors, self.r);
    d.head(n) = gamma * (b.head(n) + self.r.head(n));
    d.segment(n, n) = self.r.head(n);
    d.tail(self.n_held()) = self.r.tail(self.n_held()) / gamma;
    return 0;
  }

  static int weights(N_Vector y, N_Vector weight, void* user) noexcept {
    const auto& self = *static_cast<const Impl*>(user);
    const Map at = view(y);
    Map w = view(weight);
    const Index n = self.n();
    const double position = at.head(n).lpNorm<Eigen::Infinity>() + self.scale.position;
    const double rate = at.segment(n, n).lpNorm<Eigen::Infinity>() + self.scale.rate;
    w.head(n).setConstant(1 / (self.relative_tolerance * position));
    w.segment(n, n).setConstant(1 / (self.relative_tolerance * rate));
    // lambda follows from the accelerations in the same linear equations.
    w.tail(self.n_held()).setZero();
    return 0;
  }

  static void silent(int, const char*, const char*, char*, void*) noexcept {}

  static SUNMatrix_ID matrix_id(SUNMatrix) noexcept { return SUNMATRIX_CUSTOM; }
  static int nothing(SUNMatrix) noexcept { return 0; }
  static SUNLinearSolver_Type solver_type(SUNLinearSolver) noexcept {
    return SUNLINEARSOLVER_DIRECT;
  }
  static int initialise(SUNLinearSolver) noexcept { return 0; }

  void set_up_linear_solver() {
    matrix = SUNMatNewEmpty(context);
    solver = SUNLinSolNewEmpty(context);
    if (!matrix || !solver) throw std::runtime_error("SUNDIALS: no linear solver");
    matrix->ops->getid = &matrix_id;
    matrix->ops->zero = &nothing;
    solver->content = this;
    solver->ops->gettype = &solver_type;
    solver->ops->initialize = &initialise;
    solver->ops->setup = &factorise;
    solver->ops->solve = &solve;
  }
};

IdaSolver::IdaSolver(Equations& equations, double relative_tolerance)
    : impl_(std::make_unique<Impl>(equations, relative_tolerance)) {
  Impl& self = *impl_;
  check(SUNContext_Create(nullptr, &self.context), "SUNContext_Create");
  const Index n = self.n(), size = 2 * n + self.n_held();
  self.y = N_VNew_Serial(size, self.context);
  self.y_dot = N_VNew_Serial(size, self.context);
  self.id = N_VNew_Serial(size, self.context);
  if (!self.y || !self.y_dot || !self.id) throw std::runtime_error("SUNDIALS: no vectors");
  view(self.y).setZero();
  view(self.y_dot).setZero();
  view(self.id).setZero();
  view(self.id).head(2 * n).setOnes();
  self.memory = IDACreate(self.context);
  if (!self.memory) throw std::runtime_error("SUNDIALS: IDACreate failed");
  check(IDAInit(self.memory, &Impl::residual, 0.0, self.y, self.y_dot), "IDAInit");
  check(IDASetUserData(self.memory, &self), "IDASetUserData");
  check(IDAWFtolerances(self.memory, &Impl::weights), "IDAWFtolerances");
  check(IDASetId(self.memory, self.id), "IDASetId");
  check(IDASetSuppressAlg(self.memory, SUNTRUE), "IDASetSuppressAlg");
  self.set_up_linear_solver();
  check(IDASetLinearSolver(self.memory, self.solver, self.matrix), "IDASetLinearSolver");
  check(IDASetJacFn(self.memory, &Impl::jacobian), "IDASetJacFn");
  // The caller reports failures in its own words; SUNDIALS would print them to stderr.
  check(IDASetErrHandlerFn(self.memory, &Impl::silent, nullptr), "IDASetErrHandlerFn");
}

IdaSolver::~IdaSolver() = default;

Status IdaSolver::advance(NodalState& state, const Inputs& inputs, double duration,
                          const ErrorScale& scale) noexcept {
  Impl& self = *impl_;
  const Index n = self.n();
  self.inputs = &inputs;
  // The smallest normal numbers keep the weights finite for a frame at rest on a floor at rest.
  self.scale = {scale.position + 1e-290, scale.rate + 1e-290};
  self.x_start = state.x.head(n);
  self.v_start = state.x_dot.head(n);
  Map y = view(self.y), y_dot = view(self.y_dot);
  y << Eigen::VectorXd::Zero(2 * n), state.lambda;
  y_dot << state.x_dot.head(n), state.x_ddot.head(n), Eigen::VectorXd::Zero(self.n_held());
  if (IDAReInit(self.memory, 0.0, self.y, self.y_dot) < 0 ||
      IDASetStopTime(self.memory, duration) < 0) {
    return Status::failed;
  }
  // Step by step up to the stop time: what IDA_NORMAL returns may be interpolated.
  realtype reached = 0;
  int flag = IDA_SUCCESS;
  for (int step = 0; reached < duration && flag >= 0; ++step, ++self.steps) {
    if (step == max_steps) return Status::too_many_steps;
    flag = IDASolve(self.memory, duration, &reached, self.y, self.y_dot, IDA_ONE_STEP);
  }
  if (flag == IDA_LSETUP_FAIL) return Status::matrix_singular;
  if (flag < 0) return Status::failed;
  self.set_state(duration, y, y_dot);
  state = self.state;
  return Status::ok;
}

long IdaSolver::evaluations() const noexcept { return impl_->evaluations; }
long IdaSolver::steps() const noexcept { return impl_->steps; }

}  // namespace stillframe::nodal

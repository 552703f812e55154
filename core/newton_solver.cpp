#include "core/newton_solver.hpp"

#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <memory>
#include <new>
#include <utility>

namespace stillframe {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  const std::function<bool(const VectorXd&, VectorXd&)>& forces;
  const std::function<MatrixXd(const VectorXd&)>& jacobian;
};

auto view(N_Vector v) { return Eigen::Map<VectorXd>(N_VGetArrayPointer(v), N_VGetLength(v)); }

// Exceptions must not cross the C library: anything that cannot be evaluated is a failed trial.
int forces_callback(N_Vector u, N_Vector f, void* user) noexcept try {
  const auto& problem = *static_cast<const Problem*>(user);
  VectorXd value(view(u).size());
  if (!problem.forces(view(u), value)) return 1;
  view(f) = value;
  return 0;
} catch (...) {
  return 1;
}

int jacobian_callback(N_Vector u, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector) noexcept
    try {
  const auto& problem = *static_cast<const Problem*>(user);
  Eigen::Map<MatrixXd>(SUNDenseMatrix_Data(J), SUNDenseMatrix_Rows(J), SUNDenseMatrix_Columns(J)) =
      problem.jacobian(view(u));
  return 0;
} catch (...) {
  return 1;
}

void be_silent(int, const char*, const char*, char*, void*) {}

/// Owns what SUNDIALS made.
template <class T, class Free>
std::unique_ptr<T, Free> owned(T* made, Free free) {
  if (!made) throw std::bad_alloc();
  return {made, free};
}

}  // namespace

bool solve_nonlinear(const std::function<bool(const VectorXd&, VectorXd&)>& forces,
                     const std::function<MatrixXd(const VectorXd&)>& jacobian, double scale,
                     VectorXd& q, int& iterations) {
  const Index n = q.size();
  SUNContext raw_context = nullptr;
  SUNContext_Create(nullptr, &raw_context);
  const auto context = owned(raw_context, [](SUNContext c) { SUNContext_Free(&c); });
  const auto u = owned(N_VNew_Serial(n, raw_context), &N_VDestroy);
  const auto u_scale = owned(N_VNew_Serial(n, raw_context), &N_VDestroy);
  const auto f_scale = owned(N_VNew_Serial(n, raw_context), &N_VDestroy);
  const auto J = owned(SUNDenseMatrix(n, n, raw_context), &SUNMatDestroy);
  const auto solver = owned(SUNLinSol_Dense(u.get(), J.get(), raw_context), &SUNLinSolFree);
  const auto kinsol = owned(KINCreate(raw_context), [](void* memory) { KINFree(&memory); });
  Problem problem{forces, jacobian};
  N_VConst(1.0, u_scale.get());
  N_VConst(1.0 / scale, f_scale.get());
  KINSetErrHandlerFn(kinsol.get(), be_silent, nullptr);
  KINSetUserData(kinsol.get(), &problem);
  KINInit(kinsol.get(), forces_callback, u.get());
  KINSetLinearSolver(kinsol.get(), solver.get(), J.get());
  KINSetJacFn(kinsol.get(), jacobian_callback);
  KINSetMaxSetupCalls(kinsol.get(), 1);  // a new Jacobian at every step
  KINSetFuncNormTol(kinsol.get(), 1e-10);
  KINSetScaledStepTol(kinsol.get(), 1e-15);
  // Stiff elements that turn make f large after a good step, which a line search would refuse: full
  // steps first.
  for (const auto& [strategy, most] : {std::pair(KIN_NONE, 20), std::pair(KIN_LINESEARCH, 60)}) {
    KINSetNumMaxIters(kinsol.get(), most);
    view(u.get()) = q;
    const int status = KINSol(kinsol.get(), u.get(), strategy, u_scale.get(), f_scale.get());
    long count = 0;
    KINGetNumNonlinSolvIters(kinsol.get(), &count);
    iterations += static_cast<int>(count);
    // A step below rounding means that f cannot become smaller; the caller sees what is left.
    if (status == KIN_SUCCESS || status == KIN_INITIAL_GUESS_OK || status == KIN_STEP_LT_STPTOL) {
      q = view(u.get());
      return true;
    }
  }
  return false;
}

}  // namespace stillframe

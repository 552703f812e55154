// A stiffly accurate implicit Runge-Kutta pair of ARKODE.
#include <arkode/arkode_arkstep.h>

#include <stdexcept>

#include "plant_sim/sundials/backend.hpp"

namespace stillframe {

namespace {

class Implicit final : public Integrator::Backend {
 public:
  Implicit(Eigen::Index n, Eigen::Index n_filtered, Integrator::RightHandSide f,
           Integrator::Settings given)
      : Backend(n, n_filtered, std::move(f), std::move(given)) {
    make_linear_solver();
    memory_ = ARKStepCreate(nullptr, &Backend::right_hand_side, 0.0, state_, context_);
    if (!memory_) throw std::runtime_error("SUNDIALS: ARKStepCreate failed");
    check_sundials(ARKStepSetTableNum(memory_, ARKODE_ESDIRK547L2SA_7_4_5, ARKODE_ERK_NONE),
                   "ARKStepSetTableNum");
    check_sundials(ARKStepSetUserData(memory_, static_cast<Backend*>(this)), "ARKStepSetUserData");
    check_sundials(ARKStepWFtolerances(memory_, &Backend::weights), "ARKStepWFtolerances");
    check_sundials(ARKStepSetLinearSolver(memory_, solver_, matrix_), "ARKStepSetLinearSolver");
    check_sundials(ARKStepSetJacFn(memory_, &Backend::jacobian), "ARKStepSetJacFn");
    // A reset part begins at the end of the last: its Jacobian is still a good one.
    check_sundials(ARKStepSetNonlinConvCoef(memory_, 1e-3), "ARKStepSetNonlinConvCoef");
    check_sundials(ARKStepSetErrHandlerFn(memory_, &Backend::silent, nullptr),
                   "ARKStepSetErrHandlerFn");
  }
  ~Implicit() override {
    if (memory_) ARKStepFree(&memory_);
  }

 private:
  bool restart(double duration) noexcept override {
    return ARKStepReset(memory_, 0.0, state_) >= 0 && ARKStepSetInitStep(memory_, duration) >= 0 &&
           ARKStepSetStopTime(memory_, duration) >= 0;
  }
  int step(double duration, realtype& reached) noexcept override {
    return ARKStepEvolve(memory_, duration, state_, &reached, ARK_ONE_STEP);
  }
  bool is_failure_of_f(int flag) const noexcept override {
    return flag == ARK_RHSFUNC_FAIL || flag == ARK_FIRST_RHSFUNC_ERR ||
           flag == ARK_REPTD_RHSFUNC_ERR || flag == ARK_UNREC_RHSFUNC_ERR;
  }

  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator::Backend> make_implicit(Eigen::Index n, Eigen::Index n_filtered,
                                                   Integrator::RightHandSide f,
                                                   Integrator::Settings settings) {
  return std::make_unique<Implicit>(n, n_filtered, std::move(f), std::move(settings));
}

}  // namespace stillframe

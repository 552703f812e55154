// The multistep methods of CVODE.
#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <stdexcept>

#include "plant_sim/sundials/backend.hpp"

namespace stillframe {

namespace {

class Multistep final : public Integrator::Backend {
 public:
  Multistep(Eigen::Index n, Eigen::Index n_filtered, Integrator::RightHandSide f,
            Integrator::Settings given)
      : Backend(n, n_filtered, std::move(f), std::move(given)) {
    const bool stiff = settings().scheme == Scheme::bdf;
    memory_ = CVodeCreate(stiff ? CV_BDF : CV_ADAMS, context_);
    if (!memory_) throw std::runtime_error("SUNDIALS: CVodeCreate failed");
    check_sundials(CVodeInit(memory_, &Backend::right_hand_side, 0.0, state_), "CVodeInit");
    check_sundials(CVodeSetUserData(memory_, static_cast<Backend*>(this)), "CVodeSetUserData");
    check_sundials(CVodeWFtolerances(memory_, &Backend::weights), "CVodeWFtolerances");
    if (stiff) {
      make_linear_solver();
      check_sundials(CVodeSetLinearSolver(memory_, solver_, matrix_), "CVodeSetLinearSolver");
      check_sundials(CVodeSetJacFn(memory_, &Backend::jacobian), "CVodeSetJacFn");
    } else {
      fixed_point_ = SUNNonlinSol_FixedPoint(state_, 0, context_);
      if (!fixed_point_) throw std::runtime_error("SUNDIALS: SUNNonlinSol_FixedPoint failed");
      check_sundials(CVodeSetNonlinearSolver(memory_, fixed_point_), "CVodeSetNonlinearSolver");
    }
    check_sundials(CVodeSetErrHandlerFn(memory_, &Backend::silent, nullptr),
                   "CVodeSetErrHandlerFn");
  }
  ~Multistep() override {
    if (memory_) CVodeFree(&memory_);
    if (fixed_point_) SUNNonlinSolFree(fixed_point_);
  }

 private:
  bool restart(double duration) noexcept override {
    return CVodeReInit(memory_, 0.0, state_) >= 0 && CVodeSetStopTime(memory_, duration) >= 0;
  }
  int step(double duration, realtype& reached) noexcept override {
    return CVode(memory_, duration, state_, &reached, CV_ONE_STEP);
  }
  bool is_failure_of_f(int flag) const noexcept override {
    return flag == CV_RHSFUNC_FAIL || flag == CV_FIRST_RHSFUNC_ERR ||
           flag == CV_REPTD_RHSFUNC_ERR || flag == CV_UNREC_RHSFUNC_ERR;
  }

  void* memory_ = nullptr;
  SUNNonlinearSolver fixed_point_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator::Backend> make_multistep(Eigen::Index n, Eigen::Index n_filtered,
                                                    Integrator::RightHandSide f,
                                                    Integrator::Settings settings) {
  return std::make_unique<Multistep>(n, n_filtered, std::move(f), std::move(settings));
}

}  // namespace stillframe

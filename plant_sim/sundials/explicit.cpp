// Explicit Runge-Kutta pairs of ARKODE.
#include <arkode/arkode_erkstep.h>

#include <stdexcept>

#include "plant_sim/sundials/backend.hpp"

namespace stillframe {

namespace {

ARKODE_ERKTableID table_of(Scheme scheme) {
  switch (scheme) {
    case Scheme::fehlberg:
      return ARKODE_FEHLBERG_13_7_8;
    case Scheme::runge_kutta:
      return ARKODE_ZONNEVELD_5_3_4;
    default:
      return ARKODE_DORMAND_PRINCE_7_4_5;
  }
}

class Explicit final : public Integrator::Backend {
 public:
  Explicit(Eigen::Index n, Eigen::Index n_filtered, Integrator::RightHandSide f,
           Integrator::Settings given)
      : Backend(n, n_filtered, std::move(f), std::move(given)) {
    memory_ = ERKStepCreate(&Backend::right_hand_side, 0.0, state_, context_);
    if (!memory_) throw std::runtime_error("SUNDIALS: ERKStepCreate failed");
    check_sundials(ERKStepSetTableNum(memory_, table_of(settings().scheme)), "ERKStepSetTableNum");
    check_sundials(ERKStepSetUserData(memory_, static_cast<Backend*>(this)), "ERKStepSetUserData");
    check_sundials(ERKStepWFtolerances(memory_, &Backend::weights), "ERKStepWFtolerances");
    // The caller reports failures in its own words; SUNDIALS would print them to stderr.
    check_sundials(ERKStepSetErrHandlerFn(memory_, &Backend::silent, nullptr),
                   "ERKStepSetErrHandlerFn");
  }
  ~Explicit() override {
    if (memory_) ERKStepFree(&memory_);
  }

 private:
  bool restart(double duration) noexcept override {
    const bool fixed = settings().scheme == Scheme::runge_kutta;
    const double first = fixed ? duration / settings().steps_per_part : duration;
    return ERKStepReset(memory_, 0.0, state_) >= 0 &&
           (fixed ? ERKStepSetFixedStep(memory_, first) : ERKStepSetInitStep(memory_, first)) >=
               0 &&
           ERKStepSetStopTime(memory_, duration) >= 0;
  }
  int step(double duration, realtype& reached) noexcept override {
    return ERKStepEvolve(memory_, duration, state_, &reached, ARK_ONE_STEP);
  }
  bool is_failure_of_f(int flag) const noexcept override {
    return flag == ARK_RHSFUNC_FAIL || flag == ARK_FIRST_RHSFUNC_ERR ||
           flag == ARK_REPTD_RHSFUNC_ERR || flag == ARK_UNREC_RHSFUNC_ERR;
  }

  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator::Backend> make_explicit(Eigen::Index n, Eigen::Index n_filtered,
                                                   Integrator::RightHandSide f,
                                                   Integrator::Settings settings) {
  return std::make_unique<Explicit>(n, n_filtered, std::move(f), std::move(settings));
}

}  // namespace stillframe

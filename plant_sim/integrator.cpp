#include "plant_sim/integrator.hpp"

#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

#include <cmath>
#include <stdexcept>

namespace stillframe {

namespace {

constexpr int max_steps = 100'000;  // within one sample

using Map = Eigen::Map<Eigen::VectorXd>;

Map view(N_Vector vector) { return {N_VGetArrayPointer(vector), N_VGetLength(vector)}; }

void check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("SUNDIALS: ") + what + " failed");
}

}  // namespace

struct Integrator::Impl {
  Eigen::Index n, n_filtered;
  RightHandSide f;
  double relative_tolerance;
  double position_floor = 0, velocity_floor = 0;
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  void* memory = nullptr;

  ~Impl() {
    if (memory) ERKStepFree(&memory);
    if (y) N_VDestroy(y);
    if (context) SUNContext_Free(&context);
  }

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy_dt, void* user) noexcept {
    auto& self = *static_cast<Impl*>(user);
    // Positive: recoverable, SUNDIALS tries a smaller step before it gives up.
    return self.f(t, view(y), view(dy_dt)) ? 0 : 1;
  }

  /// Of so many entries from begin on, by their size and a floor of the same unit.
  bool weigh(const Map& state, Map weight, Eigen::Index begin, Eigen::Index count,
             double floor) const noexcept {
    const double size = state.segment(begin, count).lpNorm<Eigen::Infinity>();
    const double error = relative_tolerance * (size + floor);
    weight.segment(begin, count).setConstant(1.0 / error);
    return error > 0;
  }

  static int weights(N_Vector y, N_Vector weight, void* user) noexcept {
    const auto& self = *static_cast<const Impl*>(user);
    const Map state = view(y), w = view(weight);
    const bool sound = self.weigh(state, w, 0, self.n, self.position_floor) &&
                       self.weigh(state, w, self.n, self.n, self.velocity_floor) &&
                       (self.n_filtered == 0 ||
                        self.weigh(state, w, 2 * self.n, self.n_filtered, self.position_floor));
    return sound ? 0 : -1;
  }

  static void silent(int, const char*, const char*, char*, void*) noexcept {}
};

Integrator::Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
                       Eigen::Index n_filtered)
    : impl_(std::make_unique<Impl>()) {
  Impl& self = *impl_;
  self.n = n;
  self.n_filtered = n_filtered;
  self.f = std::move(f);
  self.relative_tolerance = relative_tolerance;
  check(SUNContext_Create(nullptr, &self.context), "SUNContext_Create");
  self.y = N_VNew_Serial(2 * n + n_filtered, self.context);
  if (!self.y) throw std::runtime_error("SUNDIALS: N_VNew_Serial failed");
  view(self.y).setZero();
  self.memory = ERKStepCreate(&Impl::right_hand_side, 0.0, self.y, self.context);
  if (!self.memory) throw std::runtime_error("SUNDIALS: ERKStepCreate failed");
  check(ERKStepSetTableNum(self.memory, ARKODE_DORMAND_PRINCE_7_4_5), "ERKStepSetTableNum");
  check(ERKStepSetUserData(self.memory, &self), "ERKStepSetUserData");
  check(ERKStepWFtolerances(self.memory, &Impl::weights), "ERKStepWFtolerances");
  // The caller reports failures in its own words; SUNDIALS would print them to stderr.
  check(ERKStepSetErrHandlerFn(self.memory, &Impl::silent, nullptr), "ERKStepSetErrHandlerFn");
}

Integrator::~Integrator() = default;

Integrator::Status Integrator::advance(Eigen::VectorXd& y, double duration,
                                       double acceleration_scale) noexcept {
  Impl& self = *impl_;
  // The smallest normal numbers keep the weights finite for a frame at rest on a floor at rest.
  self.position_floor = acceleration_scale * duration * duration + 1e-290;
  self.velocity_floor = acceleration_scale * duration + 1e-290;
  view(self.y) = y;
  if (ERKStepReset(self.memory, 0.0, self.y) < 0 || ERKStepSetInitStep(self.memory, duration) < 0 ||
      ERKStepSetStopTime(self.memory, duration) < 0) {
    return Status::failed;
  }
  // Step by step up to the stop time: what ARK_NORMAL returns is interpolated.
  realtype reached = 0;
  int flag = ARK_SUCCESS;
  for (int step = 0; reached < duration && flag >= 0; ++step) {
    if (step == max_steps) return Status::too_many_steps;
    flag = ERKStepEvolve(self.memory, duration, self.y, &reached, ARK_ONE_STEP);
  }
  if (flag == ARK_RHSFUNC_FAIL || flag == ARK_FIRST_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
      flag == ARK_UNREC_RHSFUNC_ERR) {
    return Status::right_hand_side_failed;
  }
  if (flag < 0) return Status::failed;
  y = view(self.y);
  return Status::ok;
}

long Integrator::evaluations() const noexcept {
  long evaluations = 0;
  ERKStepGetNumRhsEvals(impl_->memory, &evaluations);
  return evaluations;
}

}  // namespace stillframe

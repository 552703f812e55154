#include "plant_sim/integrator.hpp"

#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace stillframe {

namespace {

constexpr int max_steps = 100'000;  // within one part
constexpr int max_failures = 20;    // of the right-hand side, one after the other

using Map = Eigen::Map<Eigen::VectorXd>;

Map view(N_Vector vector) { return {N_VGetArrayPointer(vector), N_VGetLength(vector)}; }

bool right_hand_side_failed(int flag) {
  return flag == ARK_RHSFUNC_FAIL || flag == ARK_FIRST_RHSFUNC_ERR ||
         flag == ARK_REPTD_RHSFUNC_ERR || flag == ARK_UNREC_RHSFUNC_ERR;
}

void check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("SUNDIALS: ") + what + " failed");
}

}  // namespace

struct Integrator::Impl {
  Eigen::Index n, n_filtered;
  RightHandSide f;
  double relative_tolerance;
  double position_scale = 0, velocity_scale = 0;
  long evaluations = 0;
  Eigen::VectorXd held;  ///< the state after the last step
  SUNContext context = nullptr;
  N_Vector state = nullptr;
  void* memory = nullptr;

  Impl(Eigen::Index positions, Eigen::Index filtered, RightHandSide rate, double tolerance)
      : n(positions), n_filtered(filtered), f(std::move(rate)), relative_tolerance(tolerance) {}
  ~Impl() {
    if (memory) ERKStepFree(&memory);
    if (state) N_VDestroy(state);
    if (context) SUNContext_Free(&context);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void set_up() {
    check(SUNContext_Create(nullptr, &context), "SUNContext_Create");
    state = N_VNew_Serial(2 * n + n_filtered, context);
    if (!state) throw std::runtime_error("SUNDIALS: N_VNew_Serial failed");
    view(state).setZero();
    held = view(state);
    memory = ERKStepCreate(&Impl::right_hand_side, 0.0, state, context);
    if (!memory) throw std::runtime_error("SUNDIALS: ERKStepCreate failed");
    check(ERKStepSetTableNum(memory, ARKODE_DORMAND_PRINCE_7_4_5), "ERKStepSetTableNum");
    check(ERKStepSetUserData(memory, this), "ERKStepSetUserData");
    // Steps by the present error alone, and more attempts than SUNDIALS makes by itself: an 8(7)
    // pair that was here beside this one gave up otherwise, at 1e-12, where a force began to rise.
    // This pair passes its tests without either; its measured errors are with both.
    check(ERKStepSetAdaptivityMethod(memory, ARK_ADAPT_I, 1, 0, nullptr),
          "ERKStepSetAdaptivityMethod");
    check(ERKStepSetMaxErrTestFails(memory, 20), "ERKStepSetMaxErrTestFails");
    check(ERKStepWFtolerances(memory, &Impl::weights), "ERKStepWFtolerances");
    // The caller reports failures in its own words; SUNDIALS would print them to stderr.
    check(ERKStepSetErrHandlerFn(memory, &Impl::silent, nullptr), "ERKStepSetErrHandlerFn");
  }

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy_dt, void* user) noexcept {
    auto& self = *static_cast<Impl*>(user);
    ++self.evaluations;
    return self.f(t, view(y), view(dy_dt)) ? 0 : 1;
  }

  static int weights(N_Vector y, N_Vector weight, void* user) noexcept {
    const auto& self = *static_cast<const Impl*>(user);
    const Map values = view(y);
    Map w = view(weight);
    // Of so many entries from begin on. A few roundings of what they are can be met by no step.
    const auto weigh = [&](Eigen::Index begin, Eigen::Index count, double scale) {
      if (count == 0) return true;
      constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
      const double size = values.segment(begin, count).lpNorm<Eigen::Infinity>();
      const double error = self.relative_tolerance * scale + rounding * size;
      w.segment(begin, count).setConstant(1.0 / error);
      return error > 0;
    };
    // Nothing stiff acts on what a filter has let through: it may be wrong by its own size.
    const double filtered =
        self.n_filtered > 0 ? values.tail(self.n_filtered).lpNorm<Eigen::Infinity>() : 0.0;
    const bool sound = weigh(0, self.n, self.position_scale) &&
                       weigh(self.n, self.n, self.velocity_scale) &&
                       weigh(2 * self.n, self.n_filtered, self.position_scale + filtered);
    return sound ? 0 : -1;
  }
  static void silent(int, const char*, const char*, char*, void*) noexcept {}

  /// From the held state on, at t, with this step at first.
  bool restart(double t, double step, double duration) noexcept {
    view(state) = held;
    return ERKStepReset(memory, t, state) >= 0 && ERKStepSetInitStep(memory, step) >= 0 &&
           ERKStepSetStopTime(memory, duration) >= 0;
  }
};

Integrator::Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
                       Eigen::Index n_filtered)
    : impl_(std::make_unique<Impl>(n, n_filtered, std::move(f), relative_tolerance)) {
  impl_->set_up();
}

Integrator::~Integrator() = default;

Integrator::Status Integrator::advance(Eigen::VectorXd& y, double duration, double acceleration,
                                       double within) noexcept {
  Impl& self = *impl_;
  // The smallest normal numbers keep the weights finite for a frame at rest on a floor at rest.
  self.position_scale = acceleration * within * within + 1e-290;
  self.velocity_scale = acceleration * within + 1e-290;
  self.held = y;
  if (!self.restart(0.0, duration, duration)) return Status::failed;
  // Step by step up to the stop time: what a call over the whole time returns is interpolated.
  realtype reached = 0, held_at = 0, step = duration;
  int flag = 0, failures = 0;
  for (int steps = 0; reached < duration && flag >= 0; ++steps) {
    if (steps == max_steps) return Status::too_many_steps;
    flag = ERKStepEvolve(self.memory, duration, self.state, &reached, ARK_ONE_STEP);
    if (flag >= 0) {
      self.held = view(self.state);
      held_at = reached;
      failures = 0;
      flag = ERKStepGetCurrentStep(self.memory, &step);
    } else if (right_hand_side_failed(flag) && failures++ < max_failures) {
      // A stage of too long a step may lie anywhere. SUNDIALS' explicit steps give up at once.
      step = 0.25 * std::min(step, duration - held_at);
      if (!self.restart(reached = held_at, step, duration)) return Status::failed;
      flag = 0;
    }
  }
  if (right_hand_side_failed(flag)) return Status::equations_failed;
  if (flag < 0) return Status::failed;
  y = view(self.state);
  return Status::ok;
}

long Integrator::evaluations() const noexcept { return impl_->evaluations; }

}  // namespace stillframe

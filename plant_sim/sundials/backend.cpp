#include "plant_sim/sundials/backend.hpp"

#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <stdexcept>

namespace stillframe {

namespace {

constexpr int max_steps = 100'000;  // within one part

using Map = Eigen::Map<Eigen::VectorXd>;

Map view(N_Vector vector) { return {N_VGetArrayPointer(vector), N_VGetLength(vector)}; }

}  // namespace

void check_sundials(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("SUNDIALS: ") + what + " failed");
}

Integrator::Backend::Backend(Eigen::Index n, Eigen::Index n_filtered, RightHandSide f,
                             Settings settings)
    : n_(n), n_filtered_(n_filtered), f_(std::move(f)), settings_(std::move(settings)) {
  check_sundials(SUNContext_Create(nullptr, &context_), "SUNContext_Create");
  state_ = N_VNew_Serial(2 * n + n_filtered, context_);
  if (!state_) throw std::runtime_error("SUNDIALS: N_VNew_Serial failed");
  view(state_).setZero();
}

Integrator::Backend::~Backend() {
  if (solver_) SUNLinSolFree(solver_);
  if (matrix_) SUNMatDestroy(matrix_);
  if (state_) N_VDestroy(state_);
  if (context_) SUNContext_Free(&context_);
}

void Integrator::Backend::make_linear_solver() {
  if (!settings_.jacobian) {
    throw std::invalid_argument("Integrator: an implicit scheme needs a Jacobian");
  }
  const Eigen::Index size = 2 * n_ + n_filtered_;
  J_.resize(size, size);
  matrix_ = SUNDenseMatrix(size, size, context_);
  if (matrix_) solver_ = SUNLinSol_Dense(state_, matrix_, context_);
  if (!solver_) throw std::runtime_error("SUNDIALS: SUNLinSol_Dense failed");
}

int Integrator::Backend::right_hand_side(realtype t, N_Vector y, N_Vector dy_dt,
                                         void* user) noexcept {
  auto& self = *static_cast<Backend*>(user);
  ++self.evaluations_;
  // Positive: recoverable, SUNDIALS tries a smaller step before it gives up.
  return self.f_(t, view(y), view(dy_dt)) ? 0 : 1;
}

int Integrator::Backend::jacobian(realtype t, N_Vector y, N_Vector, SUNMatrix J, void* user,
                                  N_Vector, N_Vector, N_Vector) noexcept {
  auto& self = *static_cast<Backend*>(user);
  if (!self.settings_.jacobian(t, view(y), self.J_)) return 1;
  Eigen::Map<Eigen::MatrixXd>(SUNDenseMatrix_Data(J), self.J_.rows(), self.J_.cols()) = self.J_;
  return 0;
}

int Integrator::Backend::weights(N_Vector y, N_Vector weight, void* user) noexcept {
  const auto& self = *static_cast<const Backend*>(user);
  const Map state = view(y);
  Map w = view(weight);
  // Of so many entries from begin on, by their size and a floor of the same unit.
  const auto weigh = [&](Eigen::Index begin, Eigen::Index count, double floor) {
    if (count == 0) return true;
    const double size = state.segment(begin, count).lpNorm<Eigen::Infinity>();
    const double error = self.settings_.relative_tolerance * (size + floor);
    w.segment(begin, count).setConstant(1.0 / error);
    return error > 0;
  };
  const bool sound = weigh(0, self.n_, self.position_floor_) &&
                     weigh(self.n_, self.n_, self.velocity_floor_) &&
                     weigh(2 * self.n_, self.n_filtered_, self.position_floor_);
  return sound ? 0 : -1;
}

Integrator::Status Integrator::Backend::advance(Eigen::VectorXd& y, double duration,
                                                double acceleration_scale) noexcept {
  // The smallest normal numbers keep the weights finite for a frame at rest on a floor at rest.
  position_floor_ = acceleration_scale * duration * duration + 1e-290;
  velocity_floor_ = acceleration_scale * duration + 1e-290;
  view(state_) = y;
  if (!restart(duration)) return Status::failed;
  // Step by step up to the stop time: what a call over the whole time returns is interpolated.
  realtype reached = 0;
  int flag = 0;
  for (int steps = 0; reached < duration && flag >= 0; ++steps) {
    if (steps == max_steps) return Status::too_many_steps;
    flag = step(duration, reached);
  }
  if (is_failure_of_f(flag)) return Status::right_hand_side_failed;
  if (flag < 0) return Status::failed;
  y = view(state_);
  return Status::ok;
}

}  // namespace stillframe

#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>

#include "plant_sim/integrator.hpp"

namespace stillframe {

/// What all integrators of SUNDIALS have in common: context, state, error weights, the functions
/// that are called back. Set-up: construction; advance() is hot.
class Integrator::Backend {
 public:
  Backend(Eigen::Index n, Eigen::Index n_filtered, RightHandSide f, Settings settings);
  virtual ~Backend();
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  Status advance(Eigen::VectorXd& y, double duration, double acceleration_scale) noexcept;
  long evaluations() const noexcept { return evaluations_; }

 protected:
  /// Begins again at t = 0 with state_, and must not step beyond duration.
  virtual bool restart(double duration) noexcept = 0;
  /// One step; writes the time reached. Answers the flag of SUNDIALS.
  virtual int step(double duration, realtype& reached) noexcept = 0;
  /// Whether a flag means that f could not be evaluated.
  virtual bool is_failure_of_f(int flag) const noexcept = 0;

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy_dt, void* user) noexcept;
  static int jacobian(realtype t, N_Vector y, N_Vector f, SUNMatrix J, void* user, N_Vector,
                      N_Vector, N_Vector) noexcept;
  static int weights(N_Vector y, N_Vector weight, void* user) noexcept;
  static void silent(int, const char*, const char*, char*, void*) noexcept {}
  /// A dense matrix and its solver for implicit methods, made once.
  void make_linear_solver();

  const Settings& settings() const { return settings_; }
  SUNContext context_ = nullptr;
  N_Vector state_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;

 private:
  Eigen::Index n_, n_filtered_;
  RightHandSide f_;
  Settings settings_;
  Eigen::MatrixXd J_;
  double position_floor_ = 0, velocity_floor_ = 0;
  long evaluations_ = 0;
};

/// Errors: std::runtime_error naming what SUNDIALS could not do.
void check_sundials(int flag, const char* what);

std::unique_ptr<Integrator::Backend> make_explicit(Eigen::Index n, Eigen::Index n_filtered,
                                                   Integrator::RightHandSide f,
                                                   Integrator::Settings settings);
std::unique_ptr<Integrator::Backend> make_implicit(Eigen::Index n, Eigen::Index n_filtered,
                                                   Integrator::RightHandSide f,
                                                   Integrator::Settings settings);
std::unique_ptr<Integrator::Backend> make_multistep(Eigen::Index n, Eigen::Index n_filtered,
                                                    Integrator::RightHandSide f,
                                                    Integrator::Settings settings);

}  // namespace stillframe

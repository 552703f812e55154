#include "plant_sim/motion/linear_step.hpp"

#include <cmath>

#include "core/numerics/phi_functions.hpp"
#include "plant_sim/motion/drive.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LinearStep::LinearStep(const LinearEquations& equations, double tau, double lag_rate)
    : tau_(tau),
      lags_(lag_rate > 0),
      strains_(!equations.B_p.isZero(0) || !equations.B_v.isZero(0)) {
  const auto phi = phi_functions(tau * equations.A, strains_ ? 3 : 1);
  Phi_ = phi[0];
  const MatrixXd once = tau * phi[1];
  G_a_ = once * equations.B_a;
  if (strains_) {
    const MatrixXd twice = tau * tau * phi[2], thrice = tau * tau * tau * phi[3];
    G_p_ = once * equations.B_p;
    G_v_ = once * equations.B_v + twice * equations.B_p;
    G_a_ += twice * equations.B_v + thrice * equations.B_p;
  }
  G_s_ = once * equations.B_u;
  if (lags_) G_t_ = decay_response(equations.A, equations.B_u, lag_rate, tau);
  G_f_ = once * equations.B_f;
}

void LinearStep::apply(const Drive& drive, const Start& start, const Eigen::Ref<const VectorXd>& y,
                       Eigen::Ref<VectorXd> out) const noexcept {
  out.noalias() = Phi_ * y;
  out.noalias() += G_a_ * drive.floor().floor_acceleration();
  out.noalias() += G_s_ * start.settled;
  if (strains_) {
    out.noalias() += G_p_ * start.q_r;
    out.noalias() += G_v_ * start.q_r_dot;
  }
  if (lags_) out.noalias() += G_t_ * start.transient;
  if (drive.external().size() > 0) out.noalias() += G_f_ * drive.external();
}

void gather(const Drive& drive, double from, LinearStep::Start& start) noexcept {
  drive.floor().floor_at(from, start.q_r, start.q_r_dot);
  const double left = from > 0 ? std::exp(-drive.actuators().rate() * from) : 1.0;
  for (Index i = 0; i < start.settled.size(); ++i) {
    start.settled(i) = drive.actuators().settled(i);
    start.transient(i) = left * drive.actuators().transient(i);
  }
}

LinearStep::Start start_for(const Drive& drive) {
  const VectorXd q_r = drive.floor().floor_acceleration();
  const VectorXd legs = VectorXd::Zero(static_cast<Index>(drive.legs().size()));
  return {q_r, q_r, legs, legs};
}

}  // namespace stillframe

#include "plant_sim/integrator.hpp"

#include "plant_sim/sundials/backend.hpp"

namespace stillframe {

namespace {

std::unique_ptr<Integrator::Backend> make(Eigen::Index n, Eigen::Index n_filtered,
                                          Integrator::RightHandSide f,
                                          Integrator::Settings settings) {
  switch (settings.scheme) {
    case Scheme::implicit_runge_kutta:
      return make_implicit(n, n_filtered, std::move(f), std::move(settings));
    case Scheme::adams:
    case Scheme::bdf:
      return make_multistep(n, n_filtered, std::move(f), std::move(settings));
    default:
      return make_explicit(n, n_filtered, std::move(f), std::move(settings));
  }
}

}  // namespace

Integrator::Integrator(Eigen::Index n, RightHandSide f, Settings settings, Eigen::Index n_filtered)
    : backend_(make(n, n_filtered, std::move(f), std::move(settings))) {}

Integrator::Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
                       Eigen::Index n_filtered)
    : Integrator(n, std::move(f),
                 Settings{.scheme = Scheme::dormand_prince,
                          .relative_tolerance = relative_tolerance,
                          .steps_per_part = 1,
                          .jacobian = {}},
                 n_filtered) {}

Integrator::~Integrator() = default;

Integrator::Status Integrator::advance(Eigen::VectorXd& y, double duration,
                                       double acceleration_scale) noexcept {
  return backend_->advance(y, duration, acceleration_scale);
}

long Integrator::evaluations() const noexcept { return backend_->evaluations(); }

}  // namespace stillframe

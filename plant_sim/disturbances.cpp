#include "plant_sim/disturbances.hpp"

#include "core/errors/input_error.hpp"

namespace stillframe {

Disturbances::Disturbances(const Scene& scene, const Model& model, double sample_time)
    : patterns_(model.n_x, static_cast<Index>(scene.disturbances.size())),
      values_(Eigen::VectorXd::Zero(patterns_.cols())),
      forces_(Eigen::VectorXd::Zero(scene.disturbances.empty() ? 0 : model.n_x)) {
  Index i = 0;
  for (const SceneDisturbance& disturbance : scene.disturbances) {
    courses_.emplace_back(disturbance, sample_time);
    patterns_.col(i) =
        model.translation_row(model.node_index(disturbance.node), disturbance.direction)
            .transpose();
    // A direction is a unit vector; 1e-9 of it is far above the rounding of a basis.
    if (patterns_.col(i).head(model.n_x - model.n_rx).norm() < 1e-9) {
      throw InputError(disturbance.place + ": disturbance '" + disturbance.name + "': node '" +
                       disturbance.node +
                       "' is fixed or prescribed along this direction, a force does nothing there");
    }
    ++i;
  }
}

void Disturbances::take(std::int64_t k) noexcept {
  if (courses_.empty()) return;
  for (Index i = 0; i < values_.size(); ++i) values_(i) = courses_[static_cast<size_t>(i)].at(k);
  forces_.noalias() = patterns_ * values_;
}

}  // namespace stillframe

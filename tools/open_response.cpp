#include "tools/open_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/own_values.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "tools/reduction_text.hpp"
#include "tools/stability_note.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Modes of a large scene: an axis ends at four times the twelfth, which of chains and plates is
/// below the forty-eighth; what is above is said.
constexpr Index most_peaks = 60, least_peaks = 25;
/// A dense response that nothing damps is refined at nearly every frequency.
constexpr Index fewest_coordinates = 100;

}  // namespace

OpenResponse::OpenResponse(const Scene& scene, Patience& patience) : patience_(patience) {
  if (scene.inputs.empty() || scene.outputs.empty()) {
    throw InputError(scene.file +
                     ": singular values need at least one of 'inputs' and of 'outputs'");
  }
  std::optional<Model> large;
  if (!scene.reduction) large = large_scene(scene, least_peaks, fewest_coordinates);
  if (large) {
    large_ = std::make_unique<Large>(std::move(*large));
    patience.now("equilibrium");
    large_->state = sparse_equilibrium(large_->mixed).state;
    patience.now("the lowest modes");
    stable_ = warn_unless_stable(large_->mixed, large_->state, [&] {
      SceneReduction asked;
      asked.n_modes = std::min(most_peaks, large_->mixed.n_coordinates() / 4);
      reduced_ = reduced_model(large_->mixed, large_->state, scene.inputs, scene.outputs, asked);
      linear_ = reduced_->linear;
    });
    large_->response.emplace(
        large_->mixed, large_->state,
        mixed_signals(large_->mixed, large_->state, scene.inputs, scene.outputs));
    return;
  }
  patience.now("linearising");
  if (scene.reduction) {
    reduced_ = stable_reduced_model(scene, {scene.inputs, scene.outputs});
    linear_ = reduced_->linear;
    stable_ = true;  // what is not is not reduced
    return;
  }
  const Model model = make_model(scene);
  linear_ = linearise(model, scene.inputs, scene.outputs);
  stable_ = warn_unless_stable(model, linear_);
}

FrequencyRange OpenResponse::range() const {
  return frequency_range(linear_.q_names.empty() ? VectorXd() : own_frequencies_hz(linear_), {}, 0);
}

MatrixXd OpenResponse::singular_values(const VectorXd& frequencies_hz) {
  patience_.now("singular values");
  const VectorXd omega = two_pi * frequencies_hz;
  if (!large_) return singular_values_over(state_space(linear_), omega).transpose();
  MatrixXd rows;
  for (Index i = 0; i < omega.size(); ++i) {
    patience_.now("singular values",
                  100 * static_cast<double>(i) / static_cast<double>(omega.size()));
    const Eigen::MatrixXcd G = (*large_->response)({0, omega(i)});
    if (i == 0) rows.resize(omega.size(), std::min(G.rows(), G.cols()));
    if (G.allFinite()) {
      rows.row(i) = stillframe::singular_values(G).transpose();
    } else {
      rows.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return rows;
}

VectorXd OpenResponse::difference_at_most(const VectorXd& frequencies_hz) const {
  if (large_ || !reduced_) return {};
  return bounds_of(*reduced_, frequencies_hz);
}

std::optional<LargestGain> OpenResponse::peaks() const {
  if (large_ && !reduced_) return std::nullopt;
  return LargestGain(state_space(linear_));
}

double OpenResponse::peaks_to_hz() const {
  return large_ && reduced_ ? reduced_->first_left_out_hz : infinity;
}

}  // namespace stillframe::tools

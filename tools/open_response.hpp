#pragma once

#include <memory>
#include <optional>

#include "core/mechanics/sparse/reduced_model.hpp"
#include "core/mechanics/sparse/sparse_response.hpp"
#include "core/systems/frequency_range.hpp"
#include "core/systems/resonances.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"

namespace stillframe::tools {

/// Outputs from inputs of a scene about its operating point, without control: of its whole model,
/// on its lowest modes where it says `reduce`, or, of a large scene, by factors of its own at every
/// frequency, beside a reduced model that says where it peaks.
class OpenResponse {
 public:
  /// Warns where the operating point is not stable. Errors: InputError without inputs or outputs;
  /// as linearise, reduced_model and sparse_equilibrium.
  OpenResponse(const Scene& scene, Patience& patience);

  /// As of warn_unless_stable.
  const Json& stable() const { return stable_; }
  /// What an axis shows where nobody says otherwise.
  FrequencyRange range() const;

  /// Largest first, a row a frequency (Hz); NaN at a pole that nothing damps.
  Eigen::MatrixXd singular_values(const Eigen::VectorXd& frequencies_hz);
  /// What sigma_1 of the difference from the whole model is at most; empty where this is the whole.
  Eigen::VectorXd difference_at_most(const Eigen::VectorXd& frequencies_hz) const;

  /// Whether peaks are those of a model that is less than the response itself.
  bool is_large() const { return large_ != nullptr; }
  /// Where it peaks; nothing of a large scene that is not stable.
  std::optional<LargestGain> peaks() const;
  /// Hz, above which a large scene may peak where `peaks` does not say; infinite of others.
  double peaks_to_hz() const;

 private:
  Patience& patience_;
  Json stable_;
  LinearModel linear_;  ///< whole or reduced, empty of a large scene that is not stable
  std::optional<ReducedModel> reduced_;
  struct Large {
    explicit Large(Model of) : model(std::move(of)), mixed(model) {}
    Model model;
    MixedModel mixed;
    MixedState state;
    std::optional<SparseResponse> response;
  };
  std::unique_ptr<Large> large_;  ///< whose mixed model stays where its model is
};

}  // namespace stillframe::tools

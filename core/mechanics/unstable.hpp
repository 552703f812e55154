#pragma once

#include <Eigen/Core>
#include <string>

#include "core/errors/input_error.hpp"

namespace stillframe {

/// Refusal of modes(): the configuration is not stable. Whoever has the nodes can say what moves.
class Unstable : public Refusal {
 public:
  /// why: for after a colon. shape: n_d, of the mode whose square is the most negative.
  Unstable(const std::string& why, Eigen::VectorXd shape)
      : Refusal("the configuration is not stable: " + why), why_(why), shape_(std::move(shape)) {}
  const std::string& why() const { return why_; }
  const Eigen::VectorXd& shape() const { return shape_; }

 private:
  std::string why_;
  Eigen::VectorXd shape_;
};

}  // namespace stillframe

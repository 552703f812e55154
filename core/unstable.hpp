#pragma once

#include <Eigen/Core>

#include "core/yaml/input_error.hpp"

namespace stillframe {

/// Refusal of modes(): the configuration is not stable. Whoever has the nodes can say what moves.
class Unstable : public Refusal {
 public:
  /// shape: n_d, of the mode whose square is the most negative.
  Unstable(const std::string& message, Eigen::VectorXd shape)
      : Refusal(message), shape_(std::move(shape)) {}
  const Eigen::VectorXd& shape() const { return shape_; }

 private:
  Eigen::VectorXd shape_;
};

}  // namespace stillframe

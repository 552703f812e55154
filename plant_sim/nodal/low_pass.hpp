#pragma once

#include <Eigen/Core>
#include <vector>

#include "plant_sim/nodal/collocation.hpp"

namespace stillframe::nodal {

/// Low-passes s' = omega (sigma - s) of some stresses, each exact for the polynomial through the
/// values at the stages of a step. Set-up: construction; the rest is hot: noexcept, no allocation.
class LowPass {
 public:
  /// rows: of e; rate: omega, 1/s; method must outlive this.
  LowPass(std::vector<Eigen::Index> rows, double rate, const Collocation& method);

  /// Notes what the filters see at stage i: sigma - sigma_a (both n_e, N).
  void see(Eigen::Index i, const Eigen::VectorXd& sigma, const Eigen::VectorXd& sigma_a) noexcept;
  /// Goes on by the step (s) whose stages were noted.
  void step(double h) noexcept;
  /// Where the filters stand (one each, N).
  void start_at(const Eigen::VectorXd& sigma, const Eigen::VectorXd& sigma_a) noexcept;
  void set(const Eigen::VectorXd& state) noexcept { state_ = state; }
  const Eigen::VectorXd& state() const noexcept { return state_; }

 private:
  void weigh(double z) noexcept;

  std::vector<Eigen::Index> rows_;
  double rate_;
  const Collocation& method_;
  Eigen::MatrixXd stages_;                ///< rows x s
  Eigen::RowVectorXd moments_, weights_;  ///< s
  double weighed_ = -1;                   ///< omega h of the present weights
  Eigen::VectorXd state_;
};

}  // namespace stillframe::nodal

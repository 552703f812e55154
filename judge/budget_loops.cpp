#include "judge/budget_loops.hpp"

#include <Eigen/QR>

#include "controller/law.hpp"
#include "core/errors/input_error.hpp"
#include "judge/loop_between.hpp"
#include "judge/response_prediction.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The accelerations of the prescribed translations as the channels of a floor move them.
MatrixXd translations_of(const LoopDesign& design, const FloorMotion& floor,
                         const std::vector<SceneSignal>& translations) {
  MatrixXd patterns(floor.map().rows(), std::ssize(translations));
  for (Index i = 0; i < patterns.cols(); ++i) {
    patterns.col(i) = design.model.prescribed_pattern(translations[static_cast<std::size_t>(i)]);
  }
  const MatrixXd moved = patterns.completeOrthogonalDecomposition().solve(floor.map());
  // Directions of a scene are written in a few digits.
  if ((patterns * moved - floor.map()).norm() > 1e-6 * floor.map().norm()) {
    throw InputError(design.scene.file +
                     ": the floor moves prescribed angles or deformations, which are no inputs of "
                     "a loop; allowed are floors that move translations");
  }
  return moved;
}

/// A feed-forward that hears channels of which its own are combinations.
FeedForward hearing(const FeedForward& filter, const MatrixXd& heard) {
  FeedForward result{.memory = filter.memory, .n_taps = filter.n_taps};
  const Index p = heard.rows(), c = heard.cols();
  result.weights.resize(filter.weights.rows(), c * filter.n_terms());
  for (Index i = 0; i < filter.n_terms(); ++i) {
    result.weights.middleCols(i * c, c) = filter.weights.middleCols(i * p, p) * heard;
  }
  return result;
}

/// The plant on a floor that stands still, with `n` inputs that do nothing to it.
SampledPlant at_rest(SampledPlant plant, Index n) {
  const Index n_x = plant.Phi.rows() - plant.n_exogenous;
  plant.Phi = plant.Phi.topLeftCorner(n_x, n_x).eval();
  for (MatrixXd* M : {&plant.Gamma_0, &plant.Gamma_u}) *M = M->topRows(n_x).eval();
  for (MatrixXd* M : {&plant.C_y, &plant.C_sigma, &plant.C_report}) *M = M->leftCols(n_x).eval();
  plant.Gamma_w.setZero(n_x, n);
  plant.D_yw.setZero(plant.D_yw.rows(), n);
  plant.n_exogenous = 0;
  return plant;
}

}  // namespace

BudgetLoops::BudgetLoops(const LoopDesign& design, const FloorMotion& floor,
                         const std::vector<std::string>& outputs)
    : design_(design), heard_(floor.inputs() * floor.map()) {
  std::vector<SceneSignal> inputs = prescribed_translations(design.scene);
  moved_ = translations_of(design, floor, inputs);
  for (SceneSignal& force : force_signals(design.scene)) inputs.push_back(std::move(force));
  plant_ = plant_between(design, inputs, outputs);
}

SampledLoop BudgetLoops::around(const VectorXd& moved, const VectorXd& heard,
                                BudgetMethod method) const {
  SampledPlant plant = plant_;
  plant.Gamma_w = plant_.Gamma_w * moved;
  plant.D_yw = plant_.D_yw * moved;
  if (method == BudgetMethod::passive) return open_loop(plant);
  DiscreteLaw law = controller::law_from_gains(design_.gains);
  if (method != BudgetMethod::feed_forward || heard.isZero(0)) {
    law.feed_forward = {};
  } else if (design_.gains.feed_forward.filter.empty()) {
    law.feed_forward.B *= heard;
    law.feed_forward.D *= heard;
  } else {
    law.feed_forward = feed_forward_system(hearing(design_.gains.feed_forward.filter, heard));
  }
  return close_loop(plant, law);
}

SampledLoop BudgetLoops::of_floor(Index channel, BudgetMethod method) const {
  VectorXd moved = VectorXd::Zero(plant_.Gamma_w.cols());
  moved.head(moved_.rows()) = moved_.col(channel);
  return around(moved, heard_.col(channel), method);
}

SampledLoop BudgetLoops::of_force(Index disturbance, BudgetMethod method) const {
  const VectorXd moved = VectorXd::Unit(plant_.Gamma_w.cols(), moved_.rows() + disturbance);
  return around(moved, VectorXd::Zero(heard_.rows()), method);
}

LinearSystem BudgetLoops::of_force_sensors() const {
  DiscreteLaw law = controller::law_from_gains(design_.gains);
  law.feed_forward = {};
  const SampledLoop loop = close_loop(at_rest(plant_, 0), law);
  return {.A = loop.A, .B = loop.B_v, .C = loop.C, .D = loop.D_v};
}

LinearSystem BudgetLoops::of_floor_sensors() const {
  const DiscreteLaw law = controller::law_from_gains(design_.gains);
  const SampledLoop loop = close_loop(at_rest(plant_, law.feed_forward.D.cols()), law);
  return {.A = loop.A, .B = loop.B, .C = loop.C, .D = loop.D};
}

}  // namespace stillframe::judge

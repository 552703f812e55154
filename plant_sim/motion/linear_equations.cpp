#include "plant_sim/motion/linear_equations.hpp"

#include <Eigen/LU>

#include "core/linearisation.hpp"
#include "core/state_space.hpp"

namespace stillframe {

using Eigen::MatrixXd;

namespace {

/// The acceleration of every prescribed coordinate as an input.
std::vector<SceneSignal> prescribed_inputs(const Scene& scene) {
  std::vector<SceneSignal> signals;
  for (const SceneConstraint& motion : scene.prescribed) {
    SceneSignal signal;
    signal.place = motion.place;
    signal.node = motion.node;
    signal.element = motion.element;
    signal.mode = motion.mode;
    if (!motion.element.empty()) {
      signal.quantity = Quantity::deformation_acceleration;
      signals.push_back(signal);
    }
    if (motion.rotation) {
      signal.quantity = Quantity::angular_acceleration;
      signals.push_back(signal);
    }
    signal.quantity = Quantity::acceleration;
    for (const Eigen::Vector3d& direction : motion.directions) {
      signal.direction = direction;
      signals.push_back(signal);
    }
  }
  return signals;
}

/// q^r = P w for the inputs w; n_r x n_r.
MatrixXd patterns(const Model& model, const std::vector<SceneSignal>& signals) {
  MatrixXd P(model.n_r, static_cast<Index>(signals.size()));
  for (size_t j = 0; j < signals.size(); ++j) {
    P.col(static_cast<Index>(j)) = model.prescribed_pattern(signals[j]);
  }
  return P;
}

}  // namespace

LinearEquations::LinearEquations(const MinimalEquations& equations, const Scene& scene,
                                 const NominalMotion& nominal, const FramePoints& points) {
  const Model& model = equations.model();
  const Index n = equations.n_d(), m = equations.n_legs(), f = equations.n_filtered();
  std::vector<SceneSignal> inputs = prescribed_inputs(scene);
  const auto n_w = static_cast<Index>(inputs.size());
  const MatrixXd P = patterns(model, inputs);
  const MatrixXd from_q_r = P.partialPivLu().inverse();
  const std::vector<SceneSignal> legs = equations.leg_outputs();
  inputs.insert(inputs.end(), legs.begin(), legs.end());

  Lineariser lineariser(model, inputs, legs);
  const LinearModel& linear = lineariser.about(nominal);
  const auto M = mass_factors(linear);
  const Index size = equations.size();
  for (MatrixXd* B : {&B_p, &B_v, &B_a}) *B = MatrixXd::Zero(size, model.n_r);
  A = MatrixXd::Zero(size, size);
  B_u = MatrixXd::Zero(size, m);
  B_f = MatrixXd::Zero(size, model.n_x);
  A.block(0, n, n, n).setIdentity();
  A.block(n, 0, n, n) = -M.solve(linear.stiffness());
  A.block(n, n, n, n) = -M.solve(linear.damping());
  B_a.middleRows(n, n) = -M.solve(linear.M_r.leftCols(n_w)) * from_q_r;
  B_v.middleRows(n, n) = -M.solve(linear.damping_r().leftCols(n_w)) * from_q_r;
  B_p.middleRows(n, n) = -M.solve(linear.stiffness_r().leftCols(n_w)) * from_q_r;
  B_u.middleRows(n, n) = M.solve(linear.B.rightCols(m));
  B_f.middleRows(n, n) = M.solve(MatrixXd(lineariser.data().DF.transpose()));

  S_y = MatrixXd::Zero(m, size);
  S_y.leftCols(n) = linear.Y_p;
  S_y.middleCols(n, n) = linear.Y_v;
  S_p = linear.R_p.leftCols(n_w) * from_q_r;
  S_v = linear.R_v.leftCols(n_w) * from_q_r;
  if (f > 0) {
    const double gain = equations.filter_rate() / equations.stress_scale();
    A.bottomRows(f) = gain * S_y;
    A.bottomRightCorner(f, f).diagonal().array() -= equations.filter_rate();
    B_p.bottomRows(f) = gain * S_p;
    B_v.bottomRows(f) = gain * S_v;
  }

  Data data = lineariser.data();
  const MatrixXd rows = points.jacobian(data);
  V_y = MatrixXd::Zero(points.size(), size);
  V_y.middleCols(n, n) = rows * data.DF;
  V_r = rows * prescribed_transfer_functions(model, data, MatrixXd::Identity(model.n_r, model.n_r));
}

}  // namespace stillframe

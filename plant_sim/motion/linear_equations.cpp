#include "plant_sim/motion/linear_equations.hpp"

#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/model/prescribed.hpp"
#include "core/mechanics/state_space.hpp"

namespace stillframe {

using Eigen::MatrixXd;

LinearEquations::LinearEquations(const MinimalEquations& equations, const NominalMotion& nominal,
                                 const FramePoints& points) {
  const Model& model = equations.model();
  const Index n = equations.n_d(), n_w = model.n_r, m = equations.n_legs(),
              f = equations.n_filtered();
  std::vector<SceneSignal> inputs = prescribed_signals(model);
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
  B_a.middleRows(n, n) = -M.solve(linear.M_r.leftCols(n_w));
  B_v.middleRows(n, n) = -M.solve(linear.damping_r().leftCols(n_w));
  B_p.middleRows(n, n) = -M.solve(linear.stiffness_r().leftCols(n_w));
  B_u.middleRows(n, n) = M.solve(linear.B.rightCols(m));
  B_f.middleRows(n, n) = M.solve(MatrixXd(lineariser.data().DF.transpose()));

  S_y = MatrixXd::Zero(m, size);
  S_y.leftCols(n) = linear.Y_p;
  S_y.middleCols(n, n) = linear.Y_v;
  S_p = linear.R_p.leftCols(n_w);
  S_v = linear.R_v.leftCols(n_w);
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

#include "core/mechanics/linearisation/linearisation.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/linearisation/columns.hpp"
#include "core/mechanics/linearisation/mass_rounding.hpp"
#include "core/mechanics/linearisation/projection.hpp"
#include "core/mechanics/linearisation/signal_rows.hpp"
#include "core/mechanics/model/local_terms.hpp"
#include "core/mechanics/model/prescribed.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool NominalMotion::moving() const {
  return !state.q_d_dot.isZero(0) || !state.q_r_dot.isZero(0) || !state.q_r_ddot.isZero(0) ||
         !q_d_ddot.isZero(0);
}

std::string unit_of(const Model& model, const SceneSignal& signal) {
  std::string unit = traits_of(signal.quantity).unit;
  if (signal.element.empty() || !is_angle(model, signal)) return unit;
  return unit == "N" ? "N m" : unit.replace(0, 1, "rad");
}

struct Lineariser::Work {
  Work(const Model& of, const std::vector<SceneSignal>& scene_inputs,
       const std::vector<SceneSignal>& scene_outputs, Blocks wanted)
      : model(of),
        blocks(wanted),
        data(of),
        sigma_a(VectorXd::Zero(of.n_e)),
        columns(resolve(scene_inputs, scene_outputs)) {}

  /// Resolves names; answers the columns, whose patterns and reactions follow from them.
  Columns resolve(const std::vector<SceneSignal>& scene_inputs,
                  const std::vector<SceneSignal>& scene_outputs);
  void set_state(const NominalMotion& nominal);
  void project();
  void project_element(size_t k);
  void project_inertia(const ModelInertia& item);
  void project_modal_dampers();
  void drop_rounding();
  void split();
  void split_into(const MatrixXd& block, MatrixXd& dofs, MatrixXd& motions) const;
  void force_inputs();
  void output_rows();
  void kinematic_output(Index i);
  void element_output(Index i);
  void reaction_output(Index i, Index test, double sign);
  void add_columns(const Eigen::RowVectorXd& row, Index i, MatrixXd& Y, MatrixXd& R) const;

  const Model& model;
  Blocks blocks;
  Data data;
  VectorXd sigma_a;
  std::vector<ResolvedSignal> inputs, outputs;
  std::vector<Index> motion_input;  ///< input number of each prescribed pattern
  LinearModel result;
  bool moving = false;
  Columns columns;  ///< after what resolve() writes
  LocalColumns local;
  MatrixXd M, C, D, K, N, G;                      ///< n_T x n_Q
  MatrixXd B;                                     ///< n_T x n_u
  RowMatrix damper_columns, damper_column_rates;  ///< n_d x n_Q, P^T E and P^T E_1
};

Columns Lineariser::Work::resolve(const std::vector<SceneSignal>& scene_inputs,
                                  const std::vector<SceneSignal>& scene_outputs) {
  for (const Model::Dof& dof : model.dofs) {
    result.q_names.push_back(dof.name);
    result.q_units.push_back(dof.unit);
  }
  std::vector<VectorXd> patterns;
  for (const SceneSignal& input : scene_inputs) {
    inputs.push_back(resolve_input(model, input));
    result.inputs.push_back({input.name, unit_of(model, input), input.quantity});
    if (!is_motion(input.quantity)) continue;
    motion_input.push_back(static_cast<Index>(inputs.size()) - 1);
    patterns.push_back(model.prescribed_pattern(input));
  }
  std::vector<ResolvedSignal> reactions;
  for (const SceneSignal& output : scene_outputs) {
    outputs.push_back(resolve_output(model, output));
    result.outputs.push_back({output.name, unit_of(model, output), output.quantity});
    if (outputs.back().is_reaction) reactions.push_back(outputs.back());
  }
  MatrixXd matrix(model.n_r, static_cast<Index>(patterns.size()));
  for (size_t j = 0; j < patterns.size(); ++j) matrix.col(static_cast<Index>(j)) = patterns[j];
  return Columns(model, std::move(matrix), reactions);
}

void Lineariser::Work::set_state(const NominalMotion& nominal) {
  if (!generalised_forces(model, data, nominal.state, sigma_a)) {
    throw Refusal("the position to linearise about cannot be reached");
  }
  complete_accelerations(data, nominal.q_d_ddot);
  reaction_stresses(model, data);
  moving = nominal.moving();
  result.x_0 = data.x;
  result.q_0 = nominal.state.q_d;
  result.q_dot_0 = nominal.state.q_d_dot;
  result.q_ddot_0 = nominal.q_d_ddot;
  result.y_0 = nonlinear_outputs(model, data, outputs, data.x);
  result.u_0 = VectorXd::Zero(static_cast<Index>(inputs.size()));
  for (size_t j = 0; j < motion_input.size(); ++j) {
    const Quantity quantity = inputs[static_cast<size_t>(motion_input[j])].quantity;
    const VectorXd* const q_r[] = {&nominal.state.q_r, &nominal.state.q_r_dot,
                                   &nominal.state.q_r_ddot};
    result.u_0(motion_input[j]) =
        columns.patterns.col(static_cast<Index>(j)).dot(*q_r[traits_of(quantity).derivative]);
  }
}

void Lineariser::Work::project() {
  const Index n_T = columns.T.cols(), n_Q = columns.X.cols();
  for (MatrixXd* matrix : {&M, &C, &D, &K, &N, &G}) matrix->setZero(n_T, n_Q);
  for (size_t k = 0; k < model.elements.size(); ++k) project_element(k);
  if (model.modal_dampers.size() > 0) project_modal_dampers();
  for (const ModelInertia& item : model.inertias) project_inertia(item);
  if (blocks.mass) drop_rounding();
  if (blocks.stiffness) G = geometric_stiffness(model, data, columns);
}

void Lineariser::Work::project_element(size_t k) {
  const ModelElement& item = model.elements[k];
  if (item.S.size() == 0 || !(blocks.stiffness || (blocks.damping && item.damped))) return;
  RowMatrix E, E_T, E_1, E_2;
  deformation_columns(model, data, columns, k, E);
  deformation_tests(model, data, columns, k, E_T);
  const bool rates = item.damped && moving;
  if (rates) deformation_column_rates(model, data, columns, k, E_1, E_2);
  local.gather_rows(E_T, E, rates ? &E_1 : nullptr);
  if (blocks.stiffness) local.add(item.S, 0, 1.0, K);
  if (blocks.damping && item.damped) local.add(item.S_d, 0, 1.0, D);
  if (blocks.stiffness && rates) local.add(item.S_d, 1, 1.0, N);
}

/// P^T E and P^T E_1 of all deformations, and what they make of D and N.
void Lineariser::Work::project_modal_dampers() {
  const Index n_P = model.modal_dampers.cols();
  RowMatrix E, E_T, E_1, E_2, tests = RowMatrix::Zero(n_P, columns.T.cols());
  damper_columns.setZero(n_P, columns.X.cols());
  damper_column_rates.setZero(n_P, columns.X.cols());
  for (size_t k = 0; k < model.elements.size(); ++k) {
    deformation_columns(model, data, columns, k, E);
    deformation_tests(model, data, columns, k, E_T);
    if (moving) deformation_column_rates(model, data, columns, k, E_1, E_2);
    for (Index i = 0; i < E.rows(); ++i) {
      const auto P = model.modal_dampers.row(model.elements[k].row[static_cast<size_t>(i)]);
      if (P.isZero(0)) continue;
      tests.noalias() += P.transpose() * E_T.row(i);
      damper_columns.noalias() += P.transpose() * E.row(i);
      if (moving) damper_column_rates.noalias() += P.transpose() * E_1.row(i);
    }
  }
  if (blocks.damping) D.noalias() += tests.transpose() * damper_columns;
  if (blocks.stiffness && moving) N.noalias() += tests.transpose() * damper_column_rates;
}

void Lineariser::Work::project_inertia(const ModelInertia& item) {
  if (!blocks.mass && !moving) return;
  const LocalHessian L = local_mass(item, data.x);
  local.gather(item.parts, columns.T, &columns.X, moving ? &columns.X_1 : nullptr,
               moving ? &columns.X_2 : nullptr);
  if (blocks.mass) local.add(L, 0, 1.0, M);
  if (!moving) return;
  LocalVector u, v, a;
  gather(item.parts, data.x, u);
  gather(item.parts, data.x_dot, v);
  gather(item.parts, data.x_ddot, a);
  LocalHessian in_v(u.size(), u.size()), in_u(u.size(), u.size());
  item.inertia->tangents(u, v, a, Eigen::Vector3d::Zero(), in_v, in_u);
  to_node_axes(item.parts, in_v);
  to_node_axes(item.parts, in_u);
  if (blocks.damping) {
    local.add(in_v, 0, 1.0, C);
    local.add(L, 1, 2.0, C);
  }
  if (blocks.stiffness) {
    local.add(in_u, 0, 1.0, N);
    local.add(in_v, 1, 1.0, N);
    local.add(L, 2, 1.0, N);
  }
}

/// A dof that moves nothing but rounding has no mass, and whoever asks for its motion is told so.
void Lineariser::Work::drop_rounding() {
  const VectorXd rounding = mass_rounding(model, data.x, columns.X.leftCols(model.n_d));
  for (Index i = 0; i < model.n_d; ++i) {
    if (M(i, i) > rounding(i)) continue;
    M.row(i).setZero();
    M.col(i).setZero();
  }
}

/// Columns of the dofs into one matrix, those of the prescribed motions to their inputs.
void Lineariser::Work::split_into(const MatrixXd& block, MatrixXd& dofs, MatrixXd& motions) const {
  dofs = block.topLeftCorner(model.n_d, model.n_d);
  motions.setZero(model.n_d, static_cast<Index>(inputs.size()));
  for (size_t j = 0; j < motion_input.size(); ++j) {
    motions.col(motion_input[j]) = block.col(model.n_d + static_cast<Index>(j)).head(model.n_d);
  }
}

void Lineariser::Work::split() {
  split_into(M, result.M, result.M_r);
  split_into(C, result.C, result.C_r);
  split_into(D, result.D, result.D_r);
  split_into(K, result.K, result.K_r);
  split_into(N, result.N, result.N_r);
  split_into(G, result.G, result.G_r);
}

void Lineariser::Work::force_inputs() {
  B.setZero(columns.T.cols(), static_cast<Index>(inputs.size()));
  RowMatrix E_T;
  for (size_t j = 0; j < inputs.size(); ++j) {
    const ResolvedSignal& input = inputs[j];
    const auto column = static_cast<Index>(j);
    if (input.quantity == Quantity::force || input.quantity == Quantity::torque) {
      B.col(column) = columns.T.transpose() * unit_force(model, data.x, input);
    } else if (input.quantity == Quantity::stress) {
      const auto [k, i] = model.owner_of_row(input.row);
      deformation_tests(model, data, columns, k, E_T);
      B.col(column) = -E_T.row(i).transpose();
    }
  }
  result.B = B.topRows(model.n_d);
}

void Lineariser::Work::output_rows() {
  const auto n_y = static_cast<Index>(outputs.size()), n_u = static_cast<Index>(inputs.size());
  for (MatrixXd* Y : {&result.Y_p, &result.Y_v, &result.Y_a}) Y->setZero(n_y, model.n_d);
  for (MatrixXd* R : {&result.R_p, &result.R_v, &result.R_a, &result.D_u}) R->setZero(n_y, n_u);
  Index test = model.n_d;
  for (Index i = 0; i < n_y; ++i) {
    const ResolvedSignal& output = outputs[static_cast<size_t>(i)];
    if (output.is_reaction) {
      // A stress does work on its deformation with the sign opposite to that of a nodal force.
      reaction_output(i, test++, output.row >= 0 ? -1.0 : 1.0);
    } else if (output.row >= 0) {
      element_output(i);
    } else {
      kinematic_output(i);
    }
  }
}

/// Adds a row over the columns (n_Q) to row i of an output matrix of the dofs and of the inputs.
void Lineariser::Work::add_columns(const Eigen::RowVectorXd& row, Index i, MatrixXd& Y,
                                   MatrixXd& R) const {
  Y.row(i) += row.head(model.n_d);
  for (size_t j = 0; j < motion_input.size(); ++j) {
    R(i, motion_input[j]) += row(model.n_d + static_cast<Index>(j));
  }
}

/// y = p x + v x' + a x'' with x' and x'' expanded in q, q', q'': deck, section 8.2.
void Lineariser::Work::kinematic_output(Index i) {
  const KinematicRows rows = kinematic_rows(model, data, outputs[static_cast<size_t>(i)]);
  if (!rows.p.isZero(0)) add_columns(rows.p * columns.X, i, result.Y_p, result.R_p);
  if (!rows.v.isZero(0)) {
    add_columns(rows.v * columns.X, i, result.Y_v, result.R_v);
    if (moving) add_columns(rows.v * columns.X_1, i, result.Y_p, result.R_p);
  }
  if (!rows.a.isZero(0)) {
    add_columns(rows.a * columns.X, i, result.Y_a, result.R_a);
    if (!moving) return;
    add_columns(2.0 * rows.a * columns.X_1, i, result.Y_v, result.R_v);
    add_columns(rows.a * columns.X_2, i, result.Y_p, result.R_p);
  }
}

void Lineariser::Work::element_output(Index i) {
  const ResolvedSignal& output = outputs[static_cast<size_t>(i)];
  const auto [k, mode] = model.owner_of_row(output.row);
  const ModelElement& item = model.elements[k];
  RowMatrix E, E_1, E_2;
  deformation_columns(model, data, columns, k, E);
  if (moving) deformation_column_rates(model, data, columns, k, E_1, E_2);
  switch (output.quantity) {
    case Quantity::deformation:
      return add_columns(E.row(mode), i, result.Y_p, result.R_p);
    case Quantity::deformation_rate:
      add_columns(E.row(mode), i, result.Y_v, result.R_v);
      if (moving) add_columns(E_1.row(mode), i, result.Y_p, result.R_p);
      return;
    case Quantity::deformation_acceleration:
      add_columns(E.row(mode), i, result.Y_a, result.R_a);
      if (!moving) return;
      add_columns(2.0 * E_1.row(mode), i, result.Y_v, result.R_v);
      return add_columns(E_2.row(mode), i, result.Y_p, result.R_p);
    default:
      break;
  }
  if (item.S.size() > 0) {
    add_columns(item.S.row(mode) * E, i, result.Y_p, result.R_p);
    if (item.damped) {
      add_columns(item.S_d.row(mode) * E, i, result.Y_v, result.R_v);
      if (moving) add_columns(item.S_d.row(mode) * E_1, i, result.Y_p, result.R_p);
    }
  }
  if (model.modal_dampers.size() > 0) {
    const auto P = model.modal_dampers.row(output.row);
    add_columns(P * damper_columns, i, result.Y_v, result.R_v);
    if (moving) add_columns(P * damper_column_rates, i, result.Y_p, result.R_p);
  }
  for (size_t j = 0; j < inputs.size(); ++j) {
    if (inputs[j].quantity == Quantity::stress && inputs[j].row == output.row) {
      result.D_u(i, static_cast<Index>(j)) = 1.0;
    }
  }
}

/// The balance of virtual work on the test vector of a reaction: deck, section 8.4.
void Lineariser::Work::reaction_output(Index i, Index test, double sign) {
  add_columns(sign * M.row(test), i, result.Y_a, result.R_a);
  add_columns(sign * (C.row(test) + D.row(test)), i, result.Y_v, result.R_v);
  add_columns(sign * (K.row(test) + N.row(test) + G.row(test)), i, result.Y_p, result.R_p);
  result.D_u.row(i) -= sign * B.row(test);
}

Lineariser::Lineariser(const Model& model, const std::vector<SceneSignal>& inputs,
                       const std::vector<SceneSignal>& outputs, Blocks blocks)
    : work_(std::make_unique<Work>(model, inputs, outputs, blocks)) {}
Lineariser::~Lineariser() = default;
Lineariser::Lineariser(Lineariser&&) noexcept = default;

const Data& Lineariser::data() const { return work_->data; }

const LinearModel& Lineariser::about(const NominalMotion& nominal, double load_factor,
                                     const VectorXd& sigma_a) {
  work_->data.load_factor = load_factor;
  sigma_a.size() > 0 ? work_->sigma_a = sigma_a : work_->sigma_a.setZero();
  nominal.place(work_->data);
  work_->set_state(nominal);
  work_->columns.compute(work_->model, work_->data, work_->moving);
  work_->project();
  work_->split();
  work_->force_inputs();
  work_->output_rows();
  return work_->result;
}

LinearModel linearise(const Model& model, const NominalMotion& nominal,
                      const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs, Blocks blocks) {
  return Lineariser(model, inputs, outputs, blocks).about(nominal);
}

}  // namespace stillframe

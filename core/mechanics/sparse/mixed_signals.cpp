#include "core/mechanics/sparse/mixed_signals.hpp"

#include <algorithm>

#include "core/mechanics/linearisation/signal_rows.hpp"
#include "core/mechanics/state_space.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What supports and drives exert on all coordinates (n_x + n_0) at rest.
VectorXd forces_borne(const MixedModel& mixed, const MixedState& state, const SparseMatrix& E) {
  return E.transpose() * state.s - mixed.forces(state.x, state.load_factor, MixedModel::Of::all);
}

class Resolver {
 public:
  Resolver(const MixedModel& mixed, const MixedState& state)
      : mixed_(mixed),
        model_(mixed.model()),
        state_(state),
        E_(mixed.strain_rows(state.x, Of::all)),
        M_(mixed.mass(state.x, Of::all)),
        D_(mixed.damping(state.x, Of::all)),
        G_(mixed.geometric_stiffness(state, Of::all)),
        borne_(forces_borne(mixed, state, E_)) {}

  MixedSignals resolve(const std::vector<SceneSignal>& inputs,
                       const std::vector<SceneSignal>& outputs) {
    const auto n_u = static_cast<Index>(inputs.size()), n_y = static_cast<Index>(outputs.size());
    const Index n = E_.cols(), n_c = model_.n_c;
    for (MatrixXd* all : {&F_, &M_w_, &D_w_, &K_w_, &X_w_}) all->setZero(n, n_u);
    found_.e.setZero(E_.rows(), n_u);
    found_.u_0.setZero(n_u);
    found_.y_0.setZero(n_y);
    found_.S.setZero(n_y, E_.rows());
    for (MatrixXd* Y : {&found_.Y_p, &found_.Y_v, &found_.Y_a}) Y->setZero(n_y, n_c);
    for (MatrixXd* R : {&found_.R_p, &found_.R_v, &found_.R_a, &found_.D_u}) R->setZero(n_y, n_u);
    for (Index j = 0; j < n_u; ++j) add_input(inputs[static_cast<size_t>(j)], j);
    for (Index i = 0; i < n_y; ++i) add_output(outputs[static_cast<size_t>(i)], i);
    found_.F = F_.topRows(n_c);
    found_.M_w = M_w_.topRows(n_c);
    found_.D_w = D_w_.topRows(n_c);
    found_.K_w = K_w_.topRows(n_c);
    return std::move(found_);
  }

 private:
  using Of = MixedModel::Of;

  void add_input(const SceneSignal& signal, Index j) {
    const ResolvedSignal input = resolve_input(model_, signal);
    inputs_.push_back(input);
    patterns_.emplace_back(VectorXd::Zero(model_.n_r));
    found_.inputs.push_back({signal.name, unit_of(model_, signal), signal.quantity});
    if (is_motion(signal.quantity)) {
      add_motion(signal, j);
    } else if (signal.quantity == Quantity::stress) {
      const auto [k, i] = model_.owner_of_row(input.row);
      F_.col(j) = -mixed_.deformation_row(k, i, state_.x);
    } else {
      F_.col(j) = unit_force(model_, state_.x, input);
    }
  }

  void add_motion(const SceneSignal& signal, Index j) {
    VectorXd& pattern = patterns_.back();
    pattern = model_.prescribed_pattern(signal);
    X_w_.col(j).segment(model_.n_c, model_.n_rx) = pattern.head(model_.n_rx);
    const MixedModel::Prescribed driven = mixed_.prescribed(pattern, state_.x);
    found_.e.col(j) = driven.e - E_ * X_w_.col(j);
    M_w_.col(j) = M_ * X_w_.col(j);
    D_w_.col(j) = D_ * X_w_.col(j) + driven.D;
    K_w_.col(j) = G_ * X_w_.col(j) + driven.K;
    const VectorXd* values[] = {&model_.q_r_0, &model_.q_r_dot_0, &model_.q_r_ddot_0};
    found_.u_0(j) = pattern.dot(*values[traits_of(signal.quantity).derivative]);
  }

  void add_output(const SceneSignal& signal, Index i) {
    const ResolvedSignal output = resolve_output(model_, signal);
    found_.outputs.push_back({signal.name, unit_of(model_, signal), signal.quantity});
    if (signal.quantity == Quantity::stress) {
      add_stress(output, i);
    } else if (output.is_reaction) {
      add_reaction(output, i);
    } else if (output.row >= 0) {
      const auto [k, mode] = model_.owner_of_row(output.row);
      add_motion_row(mixed_.deformation_row(k, mode, state_.x), signal.quantity, i);
      if (traits_of(signal.quantity).derivative == 0) {
        found_.y_0(i) = mixed_.deformations(k, state_.x)(mode);
      }
    } else {
      const VectorXd row = unit_force(model_, state_.x, output);
      add_motion_row(row, signal.quantity, i);
      // A rotation in space is counted from where it is.
      const bool counted = signal.quantity == Quantity::position ||
                           (signal.quantity == Quantity::rotation && model_.planar);
      if (counted) found_.y_0(i) = row.head(model_.n_x).dot(state_.x);
    }
  }

  void add_motion_row(const VectorXd& row, Quantity quantity, Index i) {
    MatrixXd* Y[] = {&found_.Y_p, &found_.Y_v, &found_.Y_a};
    MatrixXd* R[] = {&found_.R_p, &found_.R_v, &found_.R_a};
    const int order = traits_of(quantity).derivative;
    Y[order]->row(i) += row.head(model_.n_c).transpose();
    R[order]->row(i) += row.transpose() * X_w_;
  }

  void add_stress(const ResolvedSignal& output, Index i) {
    const auto [k, mode] = model_.owner_of_row(output.row);
    const ModelElement& item = model_.elements[k];
    found_.S.row(i) = mixed_.stress_row(k, mode).transpose();
    found_.y_0(i) = mixed_.stresses(k, state_)(mode);
    if (output.is_reaction) return;
    add_motion_row(mixed_.viscous_row(k, mode, state_.x), Quantity::velocity, i);
    for (size_t j = 0; j < inputs_.size(); ++j) {
      const auto column = static_cast<Index>(j);
      if (inputs_[j].quantity == Quantity::stress) {
        found_.D_u(i, column) = inputs_[j].row == output.row ? 1 : 0;
      }
      for (Index m = 0; m < item.element->n_deformations(); ++m) {
        const double amount = prescribed_amount(j, item.row[static_cast<size_t>(m)]);
        if (amount == 0) continue;
        if (item.S.size() > 0) found_.R_p(i, column) += item.S(mode, m) * amount;
        if (item.damped) found_.R_v(i, column) += item.S_d(mode, m) * amount;
      }
    }
  }

  /// How much of a deformation an input prescribes.
  double prescribed_amount(size_t j, Index row) const {
    const auto& rows = model_.prescribed_rows;
    const auto found = std::find(rows.begin(), rows.end(), row);
    return found == rows.end() ? 0 : patterns_[j](model_.n_rx + (found - rows.begin()));
  }

  /// What holds a node along or about a direction: all nodal forces there.
  void add_reaction(const ResolvedSignal& output, Index i) {
    const VectorXd t = virtual_motion(model_, state_.x, output);
    const Index n_c = model_.n_c;
    found_.S.row(i) = (E_ * t).transpose();
    found_.Y_p.row(i) = (G_ * t).head(n_c).transpose();
    found_.Y_v.row(i) = (D_ * t).head(n_c).transpose();
    found_.Y_a.row(i) = (M_ * t).head(n_c).transpose();
    found_.R_p.row(i) = t.transpose() * K_w_;
    found_.R_v.row(i) = t.transpose() * D_w_;
    found_.R_a.row(i) = t.transpose() * M_w_;
    found_.D_u.row(i) = -t.transpose() * F_;
    found_.y_0(i) = t.dot(borne_);
  }

  const MixedModel& mixed_;
  const Model& model_;
  const MixedState& state_;
  SparseMatrix E_, M_, D_, G_;          ///< of all coordinates
  VectorXd borne_;                      ///< n_x + n_0
  MatrixXd F_, M_w_, D_w_, K_w_, X_w_;  ///< (n_x + n_0) x n_u
  std::vector<ResolvedSignal> inputs_;
  std::vector<VectorXd> patterns_;  ///< of each input, n_r
  MixedSignals found_;
};

}  // namespace

MixedSignals mixed_signals(const MixedModel& mixed, const MixedState& state,
                           const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs) {
  return Resolver(mixed, state).resolve(inputs, outputs);
}

VectorXd reactions_at_rest(const MixedModel& mixed, const MixedState& state,
                           const std::vector<SceneSignal>& reactions) {
  const VectorXd borne =
      forces_borne(mixed, state, mixed.strain_rows(state.x, MixedModel::Of::all));
  VectorXd y_0(std::ssize(reactions));
  for (Index i = 0; i < y_0.size(); ++i) {
    const ResolvedSignal reaction =
        resolve_output(mixed.model(), reactions[static_cast<size_t>(i)]);
    y_0(i) = virtual_motion(mixed.model(), state.x, reaction).dot(borne);
  }
  return y_0;
}

}  // namespace stillframe

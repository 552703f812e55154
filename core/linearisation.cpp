#include "core/linearisation.hpp"

#include <Eigen/LU>

#include "core/dynamics.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool is_motion(Quantity quantity) {
  return quantity == Quantity::position || quantity == Quantity::velocity ||
         quantity == Quantity::acceleration;
}

std::string unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::position:
    case Quantity::deformation:
      return "m";
    case Quantity::velocity:
      return "m/s";
    case Quantity::acceleration:
      return "m/s^2";
    case Quantity::force:
    case Quantity::stress:
      return "N";
  }
  return "";
}

namespace {

/// Derivatives of all deformations: D_q e (n_e x k) for columns D_q x (n_x x k). The dynamic
/// deformations among the conditions are set exactly, the zero ones are zero.
MatrixXd deformation_transfer(const Model& model, const Data& data, const MatrixXd& DF,
                              bool of_dofs) {
  MatrixXd DF_e = MatrixXd::Zero(model.n_e, DF.cols());
  DF_e.bottomRows(model.n_redundant) = data.D.bottomRows(model.n_redundant) * DF;
  if (of_dofs) {
    for (Index i = 0; i < model.n_d; ++i) {
      const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
      if (dof.is_deformation) DF_e(dof.index, i) = 1.0;
    }
  }
  return DF_e;
}

/// Stress resultants with those of the conditions from the equations of reaction: what holds the
/// loads.
VectorXd reaction_stresses(const Model& model, const Data& data) {
  VectorXd sigma = VectorXd::Zero(model.n_e);
  sigma.tail(model.n_redundant) = model.preload.tail(model.n_redundant);
  const MatrixXd D_redundant = data.D.bottomLeftCorner(model.n_redundant, model.n_c);
  const VectorXd load =
      model.load.head(model.n_c) - D_redundant.transpose() * sigma.tail(model.n_redundant);
  if (model.n_c > 0) sigma.head(model.n_c) = data.J.transpose().solve(load);
  return sigma;
}

void require_equilibrium(const Model& model, const Data& data) {
  VectorXd residual = data.DF.transpose() * model.load;
  residual -= deformation_transfer(model, data, data.DF, true).transpose() * model.preload;
  const double scale =
      model.preload.lpNorm<Eigen::Infinity>() + model.load.lpNorm<Eigen::Infinity>();
  Index worst = 0;
  const double largest = residual.cwiseAbs().maxCoeff(&worst);
  // A person writes preloads with about nine digits at best; the residual is stated against their
  // size.
  if (largest > 1e-9 * scale) {
    throw Refusal("the scene as written is not in equilibrium: a generalised force of " +
                  std::to_string(residual(worst)) + " N is left at dof " +
                  model.dofs[static_cast<size_t>(worst)].name +
                  "; choose preloads and loads that balance");
  }
}

class Linearisation {
 public:
  Linearisation(const Model& model, const std::vector<SceneSignal>& inputs,
                const std::vector<SceneSignal>& outputs)
      : model_(model), inputs_(inputs), outputs_(outputs), data_(model) {}

  LinearModel run() {
    geometric_transfer_functions(model_, data_);
    require_equilibrium(model_, data_);
    for (const Model::Dof& dof : model_.dofs) result_.q_names.push_back(dof.name);
    transfer_to_inputs();
    matrices();
    forces();
    output_rows();
    return std::move(result_);
  }

 private:
  /// D_r F for one column of unit motion per input; zero columns for forces.
  void transfer_to_inputs() {
    MatrixXd patterns = MatrixXd::Zero(model_.n_r, n_u());
    for (Index j = 0; j < n_u(); ++j) {
      const SceneSignal& input = inputs_[static_cast<size_t>(j)];
      result_.inputs.push_back({input.name, unit_of(input.quantity), input.quantity});
      if (is_motion(input.quantity)) {
        patterns.col(j) =
            model_.prescribed_pattern(model_.node_index(input.node), input.direction, input.place);
      }
    }
    DF_r_ = prescribed_transfer_functions(model_, data_, patterns);
    DF_e_ = deformation_transfer(model_, data_, data_.DF, true);
    DF_er_ = deformation_transfer(model_, data_, DF_r_, false);
  }

  void matrices() {
    const auto S = model_.stiffness.asDiagonal(), S_d = model_.damping.asDiagonal();
    mass_matrix(model_, data_);
    result_.M = data_.M_dd;
    result_.M_r = project_mass(model_, data_, DF_r_);
    result_.K = DF_e_.transpose() * S * DF_e_;
    result_.K_r = DF_e_.transpose() * S * DF_er_;
    result_.D = DF_e_.transpose() * S_d * DF_e_;
    result_.D_r = DF_e_.transpose() * S_d * DF_er_;
    result_.G = MatrixXd::Zero(model_.n_d, model_.n_d);
    result_.G_r = MatrixXd::Zero(model_.n_d, n_u());
    if (model_.preload.isZero(0) && model_.load.isZero(0)) return;
    const MatrixXd H = stress_hessian(model_, data_, reaction_stresses(model_, data_));
    result_.G = data_.DF.transpose() * H * data_.DF;
    result_.G_r = data_.DF.transpose() * H * DF_r_;
  }

  void forces() {
    result_.B = MatrixXd::Zero(model_.n_d, n_u());
    for (Index j = 0; j < n_u(); ++j) {
      const SceneSignal& input = inputs_[static_cast<size_t>(j)];
      if (input.quantity == Quantity::force) {
        const Eigen::RowVectorXd row =
            model_.translation_row(model_.node_index(input.node), input.direction);
        result_.B.col(j) = (row * data_.DF).transpose();
      } else if (input.quantity == Quantity::stress) {
        result_.B.col(j) = -DF_e_.row(elastic_row(input)).transpose();
      }
    }
  }

  void output_rows() {
    const Index n_y = static_cast<Index>(outputs_.size());
    result_.Y_p = result_.Y_v = result_.Y_a = MatrixXd::Zero(n_y, model_.n_d);
    result_.R_p = result_.R_v = result_.R_a = result_.D_u = MatrixXd::Zero(n_y, n_u());
    for (Index i = 0; i < n_y; ++i) {
      const SceneSignal& output = outputs_[static_cast<size_t>(i)];
      result_.outputs.push_back({output.name, unit_of(output.quantity), output.quantity});
      if (output.element.empty()) {
        node_output(i, output);
      } else {
        element_output(i, output);
      }
    }
  }

  void node_output(Index i, const SceneSignal& output) {
    const Eigen::RowVectorXd row =
        model_.translation_row(model_.node_index(output.node), output.direction);
    MatrixXd& Y = output.quantity == Quantity::position   ? result_.Y_p
                  : output.quantity == Quantity::velocity ? result_.Y_v
                                                          : result_.Y_a;
    MatrixXd& R = output.quantity == Quantity::position   ? result_.R_p
                  : output.quantity == Quantity::velocity ? result_.R_v
                                                          : result_.R_a;
    Y.row(i) = row * data_.DF;
    R.row(i) = row * DF_r_;
  }

  void element_output(Index i, const SceneSignal& output) {
    const Index e = elastic_row(output);
    if (output.quantity == Quantity::deformation) {
      result_.Y_p.row(i) = DF_e_.row(e);
      result_.R_p.row(i) = DF_er_.row(e);
      return;
    }
    result_.Y_p.row(i) = model_.stiffness(e) * DF_e_.row(e);
    result_.R_p.row(i) = model_.stiffness(e) * DF_er_.row(e);
    result_.Y_v.row(i) = model_.damping(e) * DF_e_.row(e);
    result_.R_v.row(i) = model_.damping(e) * DF_er_.row(e);
    for (Index j = 0; j < n_u(); ++j) {
      const SceneSignal& input = inputs_[static_cast<size_t>(j)];
      if (input.quantity == Quantity::stress && input.element == output.element) {
        result_.D_u(i, j) = 1.0;
      }
    }
  }

  Index elastic_row(const SceneSignal& signal) const {
    const auto& item = model_.elements[static_cast<size_t>(model_.element_index(signal.element))];
    if (!item.elastic) {
      throw InputError(signal.place + ": '" + signal.element +
                       "' is rigid; only elastic elements have a stress or a deformation here");
    }
    return item.row[0];
  }

  Index n_u() const { return static_cast<Index>(inputs_.size()); }

  const Model& model_;
  const std::vector<SceneSignal>&inputs_, &outputs_;
  Data data_;
  MatrixXd DF_r_, DF_e_, DF_er_;
  LinearModel result_;
};

}  // namespace

LinearModel linearise(const Model& model, const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs) {
  return Linearisation(model, inputs, outputs).run();
}

}  // namespace stillframe

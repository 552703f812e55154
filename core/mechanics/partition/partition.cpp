#include "core/mechanics/partition/partition.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <map>

#include "core/errors/input_error.hpp"
#include "core/mechanics/kinematics.hpp"

namespace stillframe {

namespace {

using Names = std::vector<std::string>;

/// The names whose entries carry a vector: those above a tenth of the largest, at most six, largest
/// first.
Names carriers(const Eigen::VectorXd& vector, const Names& names) {
  std::map<std::string, double> weight;
  for (Index i = 0; i < vector.size(); ++i) {
    double& w = weight[names[static_cast<size_t>(i)]];
    w = std::max(w, std::abs(vector(i)));
  }
  std::vector<std::pair<double, std::string>> sorted;
  for (const auto& [name, w] : weight) sorted.emplace_back(-w, name);
  std::sort(sorted.begin(), sorted.end());
  Names result;
  for (const auto& [w, name] : sorted) {
    if (-w >= 0.1 * -sorted.front().first && result.size() < 6) result.push_back(name);
  }
  return result;
}

std::string quoted(const Names& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text;
}

Names column_owners(const Model& model) {
  Names owners(static_cast<size_t>(model.n_x));
  const auto claim = [&](const PartMap& map, const std::string& name) {
    for (const Index column : map.column) {
      if (column >= 0 && column < model.n_x) owners[static_cast<size_t>(column)] = name;
    }
  };
  for (const ModelNode& node : model.nodes) {
    claim(node.translation, node.name);
    claim(node.rotation, node.name + " (rotation)");
  }
  return owners;
}

Names row_owners(const Model& model) {
  Names owners(static_cast<size_t>(model.n_e));
  for (const ModelElement& item : model.elements) {
    for (Index i = 0; i < item.element->n_deformations(); ++i) {
      owners[static_cast<size_t>(item.row[static_cast<size_t>(i)])] = item.name;
    }
  }
  return owners;
}

std::string motion_text(const Model& model, const Eigen::MatrixXd& null_space) {
  const Names owners = column_owners(model);
  return quoted(
      carriers(null_space.rowwise().norm(), Names(owners.begin(), owners.begin() + model.n_c)));
}

std::string condition_text(const Model& model, const Eigen::MatrixXd& left) {
  const Names owners = row_owners(model);
  return quoted(
      carriers(left.rowwise().norm(), Names(owners.begin(), owners.begin() + left.rows())));
}

std::string redundancy_text(const Model& model, const Eigen::MatrixXd& left) {
  return " (and release " + std::to_string(left.cols()) + " of the conditions of " +
         condition_text(model, left) + ", which are not independent)";
}

/// The smallest singular value of a sound J against its largest: rounding leaves about 1e-16, and a
/// sound scene written with six digits may be within 1e-6 of a singular one and must pass, so the
/// bound lies between the two.
constexpr double smallest_ratio = 1e-11;

}  // namespace

void check_partition(const Model& model, const std::string& place) {
  const Index n_conditions = model.n_e - model.n_redundant;
  if (n_conditions != model.n_c) refuse_partition(model, place);
  if (model.n_c == 0) return;
  const Data data(model);
  // The estimate from the factors may be a factor of the size off; only near the bound does the
  // decision need the singular values themselves.
  const double estimate = data.J.reciprocal_condition();
  if (estimate > 1e3 * smallest_ratio) return;
  const Eigen::MatrixXd J = dense_jacobian(model).topLeftCorner(n_conditions, model.n_c);
  const Eigen::VectorXd values = Eigen::BDCSVD<Eigen::MatrixXd>(J).singularValues();
  if (values(model.n_c - 1) > smallest_ratio * values(0)) return;
  refuse_partition(model, place);
}

void refuse_partition(const Model& model, const std::string& place) {
  const Index n_conditions = model.n_e - model.n_redundant;
  const Eigen::MatrixXd J = dense_jacobian(model).topLeftCorner(n_conditions, model.n_c);
  Eigen::MatrixXd U = Eigen::MatrixXd::Identity(n_conditions, n_conditions);
  Eigen::MatrixXd V = Eigen::MatrixXd::Identity(model.n_c, model.n_c);
  Index rank = 0;
  if (J.size() > 0) {  // Eigen decomposes no empty matrix
    const Eigen::BDCSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::VectorXd& values = svd.singularValues();
    rank = (values.array() > smallest_ratio * values(0)).count();
    U = svd.matrixU();
    V = svd.matrixV();
  }
  if (rank < model.n_c) {
    throw InputError(
        place + ": the partition leaves " + std::to_string(model.n_c - rank) +
        " free motion(s) that no dof, element or support takes up, in which these move: " +
        motion_text(model, V.rightCols(model.n_c - rank)) +
        "; add a dof, an element or a support there" +
        (rank < n_conditions ? redundancy_text(model, U.rightCols(n_conditions - rank)) : ""));
  }
  const Eigen::MatrixXd left = U.rightCols(n_conditions - rank);
  throw InputError(place + ": the conditions are " + std::to_string(n_conditions - rank) +
                   " too many (overconstrained): not independent are those of " +
                   condition_text(model, left) +
                   "; take away a dof, or a rigid element or a support among them");
}

}  // namespace stillframe

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>
#include <set>

#include "core/mechanics/dynamics.hpp"
#include "tests/random_scenes/answers.hpp"
#include "tests/random_scenes/generator/draws.hpp"

// Which coordinates the equations are solved for is nobody's business.
namespace stillframe::random_scenes {

namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;

/// A coordinate that could be a dof, and how it moves with the present ones.
struct Candidate {
  SceneDof dof;
  RowVectorXd row;
};

std::vector<Candidate> candidates(Case& scene, const Data& data) {
  const Model& model = scene.model();
  std::vector<Candidate> all;
  for (const ModelElement& element : model.elements) {
    for (Index i = 0; i < element.element->n_deformations(); ++i) {
      const Index row = element.row[static_cast<size_t>(i)], n_c = model.n_c;
      if (!model.is_elastic(row)) continue;
      SceneDof dof;
      dof.element = element.name;
      dof.mode = static_cast<int>(i) + 1;
      const Index own = row < n_c ? model.conditions[static_cast<size_t>(row)].dof : -1;
      all.push_back({dof, row < n_c ? RowVectorXd(RowVectorXd::Unit(model.n_d, own))
                                    : RowVectorXd(data.DF_e.row(row - n_c))});
    }
  }
  // In motion the coordinates of nodes may go round, and what they are dofs of is not stationary.
  if (!scene.at_rest()) return all;
  std::set<Index> taken;
  for (const ModelNode& node : model.nodes) {
    for (const PartMap* map : {&node.translation, &node.rotation}) {
      for (Index i = 0; i < map->size; ++i) {
        const Index column = map->column[static_cast<size_t>(i)];
        // The first Euler parameter moves as the square of the others.
        const bool first = map == &node.rotation && !model.planar && i == 0;
        if (first || column < 0 || column >= model.n_c + model.n_xd || !taken.insert(column).second)
          continue;
        SceneDof dof;
        dof.node = node.name;
        if (map == &node.translation) {
          dof.direction = map->basis.col(i);
        } else if (model.planar) {
          dof.rotation = true;
        } else {
          dof.euler_parameter = static_cast<int>(i);
        }
        all.push_back({dof, data.DF.row(column)});
      }
    }
  }
  return all;
}

}  // namespace

std::optional<Finding> check_dofs(Case& scene, std::uint64_t seed) {
  Draws draws(seed);
  const Model& model = scene.model();
  Data data(model), as_written(model);
  scene.operating_point().place(data);
  geometric_transfer_functions(model, data);
  geometric_transfer_functions(model, as_written);
  const std::vector<Candidate> all = candidates(scene, data),
                               before = candidates(scene, as_written);
  // Rows of unit length in the metric of the mass, some preferred by chance, the rest by what the
  // others leave open.
  const MatrixXd L = Eigen::LLT<MatrixXd>(scene.linear().M).matrixL();
  MatrixXd rows(model.n_d, all.size());
  for (size_t i = 0; i < all.size(); ++i) {
    auto column = rows.col(static_cast<Index>(i));
    column = L.triangularView<Eigen::Lower>().solve(all[i].row.transpose());
    if (column.norm() > 0) column *= draws.scale(0.1, 1) / column.norm();
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
  const auto pivots = qr.matrixQR().diagonal().head(std::min(rows.rows(), rows.cols())).cwiseAbs();
  // Without as many independent coordinates there is no other choice.
  if (pivots.size() < model.n_d || !(pivots(model.n_d - 1) > 1e-4 * pivots(0))) return std::nullopt;
  Scene other = scene.scene();
  other.dofs.clear();
  other.automatic_dofs = false;
  MatrixXd there(model.n_d, model.n_d), here = there;
  for (Index i = 0; i < model.n_d; ++i) {
    const auto chosen = static_cast<size_t>(qr.colsPermutation().indices()(i));
    here.row(i) = all[chosen].row;
    there.row(i) = before[chosen].row;
    SceneDof dof = all[chosen].dof;
    dof.place = "other dofs";
    other.dofs.push_back(dof);
  }
  // Coordinates that have changed by half on the way from the scene as written to the operating
  // point may determine nothing somewhere between, and then lead nowhere.
  const MatrixXd change = there * here.partialPivLu().inverse();
  if (!((change - MatrixXd::Identity(model.n_d, model.n_d)).norm() <= 0.5)) return std::nullopt;
  const auto at = places(scene);
  const double eps = 10 * static_cast<double>(all.size()) * std::numeric_limits<double>::epsilon();
  return compare(scene.scene(), own_answers(scene), answers(other, at), eps);
}

}  // namespace stillframe::random_scenes

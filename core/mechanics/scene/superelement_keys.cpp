#include "core/mechanics/scene/superelement_keys.hpp"

#include <Eigen/SVD>
#include <algorithm>

#include "core/mechanics/elements/element.hpp"
#include "core/mechanics/scene/body_file.hpp"
#include "core/mechanics/scene/deformations.hpp"
#include "core/mechanics/scene/references.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;

Matrix3Xd centred(const Matrix3Xd& points) { return points.colwise() - points.rowwise().mean(); }

/// The rotation R that best takes points of the body to those of the scene. Points on one line do
/// not say how it is turned: then it stands as its file has it.
Matrix3d turn_of_body(const Matrix3Xd& body, const Matrix3Xd& scene) {
  const Eigen::JacobiSVD<MatrixXd> svd(MatrixXd(centred(scene) * centred(body).transpose()),
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 1e-9 * svd.singularValues()(0))) return Matrix3d::Identity();
  const Matrix3d U = svd.matrixU(), V = svd.matrixV();
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  sign(2) = (U * V.transpose()).determinant();
  return U * sign.asDiagonal() * V.transpose();
}

/// Fails if the nodes are not where the interfaces are, however the body is turned.
void check_places(const YamlReader& nodes, const FlexibleBody& body, const Matrix3Xd& scene,
                  const Matrix3d& R, const std::vector<std::string>& names) {
  const Matrix3Xd off = centred(scene) - R * centred(body.points);
  const double size = centred(body.points).colwise().norm().maxCoeff();
  Index worst = 0;
  const double most = off.colwise().norm().maxCoeff(&worst);
  // Positions of scenes are written with six digits or so.
  if (most <= 1e-5 * size) return;
  const double scene_size = centred(scene).colwise().norm().maxCoeff();
  nodes.fail("node '" + names[static_cast<size_t>(worst)] + "' is " + shown(most) +
             " m from interface '" + body.interfaces[static_cast<size_t>(worst)] +
             "' of the body, however it is turned (allowed is 1e-5 of its size, " + shown(size) +
             " m; the nodes are " + shown(scene_size) + " m wide)");
}

}  // namespace

void read_superelement(const YamlReader& value, SceneElement& element, Scene& scene) {
  if (scene.planar) value.fail("a superelement is a body in space, the scene is planar");
  value.allow_only({"type", "nodes", "body", "damping_time"});
  const YamlReader nodes = value.require("nodes"), path = value.require("body");
  auto data = std::make_shared<SceneSuperelement>();
  const FlexibleBody body = read_flexible_body(path, data->files);
  for (const ReadFile& file : data->files) {
    scene.bodies_hash = text_hash(scene.bodies_hash + file.bytes);
  }
  const auto items = nodes.items();
  const Index n = body.points.cols();
  if (static_cast<Index>(items.size()) != n) {
    nodes.fail("found " + std::to_string(items.size()) + " nodes, the body has " +
               std::to_string(n) + " interfaces");
  }
  Matrix3Xd positions(3, n);
  for (const YamlReader& item : items) {
    const SceneNode& node = read_node_name(item, scene);
    if (std::find(data->nodes.begin(), data->nodes.end(), node.name) != data->nodes.end()) {
      item.fail("node '" + node.name + "' is named twice");
    }
    positions.col(static_cast<Index>(data->nodes.size())) = node.position;
    data->nodes.push_back(node.name);
  }
  const Matrix3d R = turn_of_body(body.points, positions);
  check_places(nodes, body, positions, R, data->nodes);
  data->s = R * (body.points.colwise() - body.points.col(0));
  data->n_modes = body.n_modes;

  const Index size = body.M.rows();
  MatrixXd turn = MatrixXd::Identity(size, size);
  for (Index k = 0; k < 2 * n; ++k) turn.block<3, 3>(3 * k, 3 * k) = R;
  data->M = turn * body.M * turn.transpose();
  const MatrixXd K = turn * body.K * turn.transpose();
  set_deformations(element, size - 6);
  element.stiffness = K.bottomRightCorner(size - 6, size - 6);
  if (const auto given = value.find("damping_time")) {
    data->damping_time = given->non_negative();
    element.damping = data->damping_time * element.stiffness;
  }
  for (Index i = 0; i < body.n_modes; i += 3) {
    const std::string name = element.name + "/modes_" + std::to_string(i + 1);
    scene.nodes.push_back({name, value.place(), positions.col(0), true});
    data->mode_nodes.push_back(name);
    for (Index axis = body.n_modes - i; axis < 3; ++axis) {
      SceneConstraint unused;
      unused.node = name;
      unused.place = value.place();
      unused.directions.push_back(Eigen::Vector3d::Unit(axis));
      scene.supports.push_back(unused);
    }
  }
  if (7 * n + 3 * static_cast<Index>(data->mode_nodes.size()) > max_local) {
    path.fail(std::to_string(n) + " interfaces and " + std::to_string(body.n_modes) +
              " modes are too many: 7 coordinates an interface and 3 for every 3 modes may be " +
              std::to_string(max_local) + " together");
  }
  element.node_p = data->nodes.front();
  element.node_q = n > 1 ? data->nodes[1] : data->nodes.front();
  element.superelement = data;
}

}  // namespace stillframe

#include "core/yaml/turned.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/yaml/reader.hpp"
#include "core/yaml/to_number.hpp"

namespace stillframe {

namespace {

using Kind = YamlTree::Kind;

bool is_one_of(const std::string& key, std::initializer_list<std::string_view> keys) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

Eigen::Matrix3d rotation(char axis, const Turn& turn) {
  const Eigen::Index i = axis - 'x', j = (i + 1) % 3, k = (i + 2) % 3;
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  R(i, i) = 1;
  R(j, j) = R(k, k) = turn.cos;
  R(j, k) = -turn.sin;
  R(k, j) = turn.sin;
  return R;
}

std::optional<Eigen::VectorXd> numbers_of(const YamlTree& tree) {
  if (!tree.is_sequence()) return std::nullopt;
  Eigen::VectorXd values(static_cast<Eigen::Index>(tree.children.size()));
  for (std::size_t i = 0; i < tree.children.size(); ++i) {
    const YamlTree& child = tree.children[i];
    const auto value = child.is_scalar() ? to_number(child.text) : std::nullopt;
    if (!value) return std::nullopt;
    values(static_cast<Eigen::Index>(i)) = *value;
  }
  return values;
}

YamlTree number(const YAML::Mark& mark, double value) {
  // No sign of zero.
  return {.mark = mark, .kind = Kind::scalar, .text = shortest_digits(value + 0.0)};
}

YamlTree sequence(const YAML::Mark& mark, const Eigen::VectorXd& values) {
  YamlTree tree{.mark = mark, .kind = Kind::sequence};
  for (const double value : values) tree.children.push_back(number(mark, value));
  return tree;
}

/// Two numbers are of a planar scene, which turns about z.
void turn_vector(YamlTree& tree, const Eigen::Matrix3d& R) {
  const auto values = numbers_of(tree);
  if (!values) return;
  if (values->size() == 3) tree = sequence(tree.mark, R * *values);
  if (values->size() == 2) tree = sequence(tree.mark, R.topLeftCorner<2, 2>() * *values);
}

/// x, y or z as a vector.
std::optional<Eigen::Vector3d> letter(const YamlTree& tree) {
  if (!tree.is_scalar() || !is_one_of(tree.text, {"x", "y", "z"})) return std::nullopt;
  return Eigen::Vector3d::Unit(tree.text[0] - 'x');
}

void turn_direction(YamlTree& tree, char axis, const Eigen::Matrix3d& R) {
  if (const auto unit = letter(tree)) {
    if (tree.text[0] != axis) tree = sequence(tree.mark, R * *unit);
  } else {
    turn_vector(tree, R);
  }
}

/// Both directions across the axis are all directions across it, turned or not.
void turn_directions(YamlTree& tree, char axis, const Eigen::Matrix3d& R) {
  const auto n_across =
      std::count_if(tree.children.begin(), tree.children.end(),
                    [&](const YamlTree& child) { return letter(child) && child.text[0] != axis; });
  for (YamlTree& child : tree.children) {
    if (n_across == 2 && letter(child)) continue;
    turn_direction(child, axis, R);
  }
}

void turn_inertia(YamlTree& tree, const Eigen::Matrix3d& R) {
  Eigen::Matrix3d inertia;
  if (const auto moments = numbers_of(tree)) {
    if (moments->size() != 3) return;
    inertia = moments->asDiagonal();
  } else {
    if (!tree.is_sequence() || tree.children.size() != 3) return;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto row = numbers_of(tree.children[static_cast<std::size_t>(i)]);
      if (!row || row->size() != 3) return;
      inertia.row(i) = row->transpose();
    }
  }
  const Eigen::Matrix3d product = R * inertia * R.transpose();
  const Eigen::Matrix3d turned = (product + product.transpose()) / 2;
  YamlTree rows{.mark = tree.mark, .kind = Kind::sequence};
  for (Eigen::Index i = 0; i < 3; ++i) {
    rows.children.push_back(sequence(tree.mark, turned.row(i).transpose()));
  }
  tree = rows;
}

}  // namespace

Turn turn_of_part(int part, int parts) {
  constexpr int twelfths = 12;
  const auto n = std::int64_t{twelfths} * part;
  if (n % parts != 0) {
    const double angle = 2 * std::numbers::pi * part / parts;
    return {std::cos(angle), std::sin(angle)};
  }
  const double half_root = std::numbers::sqrt3 / 2;
  const std::array<double, twelfths> cosines{1,  half_root,  0.5,  0, -0.5, -half_root,
                                             -1, -half_root, -0.5, 0, 0.5,  half_root};
  const auto i = static_cast<std::size_t>(((n / parts) % twelfths + twelfths) % twelfths);
  return {cosines[i], cosines[(i + 9) % twelfths]};
}

Turn turn_of_degrees(double degrees) {
  const double part = degrees / 30;
  if (part == std::round(part) && std::abs(part) < 1e6) {
    return turn_of_part(static_cast<int>(part), 12);
  }
  const double angle = std::numbers::pi / 180 * degrees;
  return {std::cos(angle), std::sin(angle)};
}

void turn_all(YamlTree& tree, char axis, const Turn& turn) {
  const Eigen::Matrix3d R = rotation(axis, turn);
  for (std::size_t i = 0; i < tree.children.size(); ++i) {
    YamlTree& value = tree.children[i];
    const std::string key = tree.is_map() ? tree.keys[i].text : "";
    if (is_one_of(key, {"position", "force", "torque"})) turn_vector(value, R);
    if (is_one_of(key, {"along", "orientation", "axis"})) turn_direction(value, axis, R);
    if (is_one_of(key, {"fix", "move"})) turn_directions(value, axis, R);
    if (key == "inertia") turn_inertia(value, R);
    if (value.is_map() || (value.is_sequence() && !is_one_of(key, {"inertia"}))) {
      turn_all(value, axis, turn);
    }
  }
}

}  // namespace stillframe

#include <algorithm>
#include <limits>

#include "tests/random_scenes/changed.hpp"

// A choice of axes, of an order, of units is a choice of words: no answer may depend on it.
namespace stillframe::random_scenes {

namespace {

Finding compare_with(Case& scene, const Scene& other, double eps, const Units& units = {}) {
  const auto at = places(scene);
  std::vector<std::complex<double>> at_other;
  for (const auto s : at) at_other.push_back(s / units.time);
  return compare(scene.scene(), own_answers(scene), answers(other, at_other), eps, units);
}

/// How far a scene reaches from the origin.
double reach(const Scene& scene) {
  double far = 0;
  for (const SceneNode& node : scene.nodes) far = std::max(far, node.position.norm());
  return far;
}

/// Roundings of some ten operations with each number, as both formulations sum over all elements,
/// and of positions: they carry eps of their distance from the origin, or of that at which they are
/// `shifted` to, into the lengths of elements.
double few_eps(const Scene& scene, double shifted = 0) {
  return 10 * static_cast<double>(scene.elements.size() + 1) *
         std::numeric_limits<double>::epsilon() *
         (1 + (reach(scene) + shifted) / shortest_element(scene));
}

}  // namespace

std::optional<Finding> check_placement(Case& scene, std::uint64_t seed) {
  Draws draws(seed);
  const bool planar = scene.scene().planar;
  const Eigen::Matrix3d Q = draws.rotation(planar);
  const Eigen::Vector3d t = 3 * reach(scene.scene()) * draws.point(planar);
  return compare_with(scene, moved(scene.scene(), Q, t), few_eps(scene.scene(), t.norm()));
}

std::optional<Finding> check_renumbering(Case& scene, std::uint64_t seed) {
  Draws draws(seed);
  return compare_with(scene, renumbered(scene.scene(), draws), few_eps(scene.scene()));
}

std::optional<Finding> check_units(Case& scene, std::uint64_t seed) {
  Draws draws(seed);
  // From millimetres, grams and milliseconds to kilometres, kilotonnes and minutes.
  const Units units{draws.scale(1e-3, 1e3), draws.scale(1e-3, 1e3), draws.scale(1e-2, 1e3)};
  return compare_with(scene, in_units(scene.scene(), units), few_eps(scene.scene()), units);
}

}  // namespace stillframe::random_scenes

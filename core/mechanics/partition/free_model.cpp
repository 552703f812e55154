#include "core/mechanics/partition/free_model.hpp"

#include <set>

#include "core/mechanics/model/builder.hpp"

namespace stillframe {

Model free_model(const Scene& scene) {
  Scene without = scene;
  without.dofs.clear();
  return ModelBuilder(without).build();
}

std::vector<FreeCoordinate> free_coordinates(const Model& model, const std::string& place) {
  std::vector<FreeCoordinate> coordinates;
  std::set<Index> taken;
  const auto take = [&](Index column, const std::string& node) -> SceneDof* {
    if (column < 0 || column >= model.n_c || !taken.insert(column).second) return nullptr;
    SceneDof& dof = coordinates.emplace_back(column, SceneDof{}).dof;
    dof.place = place;
    dof.node = node;
    return &dof;
  };
  for (const ModelNode& node : model.nodes) {
    for (int i = 0; i < 3; ++i) {
      if (SceneDof* dof = take(node.translation.column[static_cast<size_t>(i)], node.name)) {
        dof->direction = node.translation.basis.col(i);
      }
    }
    for (int i = 0; i < node.rotation.size; ++i) {
      SceneDof* dof = take(node.rotation.column[static_cast<size_t>(i)], node.name);
      if (!dof) continue;
      dof->rotation = model.planar;
      if (!model.planar) dof->euler_parameter = i;
    }
  }
  return coordinates;
}

std::vector<std::string> coordinate_names(const Model& model) {
  std::vector<std::string> names(static_cast<size_t>(model.n_c));
  for (const FreeCoordinate& coordinate : free_coordinates(model, "")) {
    const auto column = static_cast<size_t>(coordinate.column);
    names[column] = coordinate_name(coordinate.dof, column);
  }
  return names;
}

std::vector<std::string> coordinate_units(const Model& model) {
  std::vector<std::string> units(static_cast<size_t>(model.n_c));
  for (const FreeCoordinate& coordinate : free_coordinates(model, "")) {
    units[static_cast<size_t>(coordinate.column)] = coordinate_unit(coordinate.dof);
  }
  return units;
}

}  // namespace stillframe

#include "core/mechanics/partition/free_model.hpp"

#include "core/mechanics/model/builder.hpp"
#include "core/mechanics/partition/automatic_dofs.hpp"

namespace stillframe {

Model free_model(const Scene& scene) {
  Scene without = scene;
  without.dofs.clear();
  return ModelBuilder(without).build();
}

std::vector<std::string> coordinate_names(const Model& model) {
  std::vector<std::string> names(static_cast<size_t>(model.n_c));
  for (const FreeCoordinate& coordinate : free_coordinates(model, "")) {
    const auto column = static_cast<size_t>(coordinate.column);
    names[column] = coordinate_name(coordinate.dof, column);
  }
  return names;
}

}  // namespace stillframe

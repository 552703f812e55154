#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace stillframe {

/// How a plant moves: its formulation and its method. automatic: chosen by the scene.
enum class PlantMethod {
  automatic,
  linear,          ///< small motion, stepped exactly
  exponential,     ///< the exact linear answer and the nonlinear rest, in minimal coordinates
  dormand_prince,  ///< 5(4) of SUNDIALS, in minimal coordinates
  nodal,           ///< in nodal coordinates with constraints, by collocation
};

struct NamedPlantMethod {
  std::string_view name;
  PlantMethod method;
};

/// Every method and what scenes, messages and benches call it; docs/scene.md is held to it.
inline constexpr std::array plant_methods{
    NamedPlantMethod{"auto", PlantMethod::automatic},
    NamedPlantMethod{"linear", PlantMethod::linear},
    NamedPlantMethod{"exponential", PlantMethod::exponential},
    NamedPlantMethod{"dormand_prince", PlantMethod::dormand_prince},
    NamedPlantMethod{"nodal", PlantMethod::nodal},
};

/// A method as scenes call it.
inline std::string method_name(PlantMethod method) {
  for (const NamedPlantMethod& each : plant_methods) {
    if (each.method == method) return std::string(each.name);
  }
  return "";
}

/// The method of a name; nothing if none is called so.
inline std::optional<PlantMethod> method_named(std::string_view name) {
  for (const NamedPlantMethod& each : plant_methods) {
    if (each.name == name) return each.method;
  }
  return std::nullopt;
}

}  // namespace stillframe

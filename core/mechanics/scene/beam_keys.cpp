#include "core/mechanics/scene/beam_keys.hpp"

#include <Eigen/Geometry>

#include "core/mechanics/scene/deformations.hpp"
#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

/// A stiffness of the section, and the deformations (from 1) that it resists.
struct SectionKey {
  const char* key;
  double SceneBeam::*stiffness;
  size_t first, last;
  const char* shear_key;
  double SceneBeam::*shear;
};

constexpr SectionKey spatial_keys[] = {
    {"EA", &SceneBeam::EA, 1, 1, nullptr, nullptr},
    {"GJ", &SceneBeam::GJ, 2, 2, nullptr, nullptr},
    {"EI_y", &SceneBeam::EI_y, 3, 4, "shear_z", &SceneBeam::shear_z},
    {"EI_z", &SceneBeam::EI_z, 5, 6, "shear_y", &SceneBeam::shear_y},
};
constexpr SectionKey planar_keys[] = {
    {"EA", &SceneBeam::EA, 1, 1, nullptr, nullptr},
    {"EI", &SceneBeam::EI_z, 2, 3, "shear", &SceneBeam::shear_y},
};

/// "deformation 1" or "deformations 3 and 4".
std::string deformations_of(const SectionKey& key) {
  if (key.first == key.last) return "deformation " + std::to_string(key.first);
  return "deformations " + std::to_string(key.first) + " and " + std::to_string(key.last);
}

/// A stiffness is there if and only if one of its deformations is not rigid.
void read_section_key(const YamlReader& value, const SectionKey& key, SceneElement& element) {
  const bool rigid = element.zero[key.first - 1] && element.zero[key.last - 1];
  const std::string which = deformations_of(key);
  const bool single = key.first == key.last;
  const auto stiffness = value.find(key.key);
  const auto shear = key.shear ? value.find(key.shear_key) : std::nullopt;
  for (const auto& given : {stiffness, shear}) {
    if (given && rigid)
      given->fail(which + (single ? " is rigid and has" : " are rigid and have") + " no stiffness");
  }
  if (!stiffness && !rigid) {
    value.fail(std::string("the key '") + key.key + "' is missing (the stiffness of " + which +
               "), unless 'rigid' names " + (single ? "it" : "both"));
  }
  if (stiffness) element.beam.*key.stiffness = stiffness->positive();
  if (shear) element.beam.*key.shear = shear->positive();
}

/// n_y lies in the plane of the beam's axis and the orientation, so that they must not be parallel.
Eigen::Vector3d read_orientation(const YamlReader& value, const Scene& scene,
                                 const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const auto orientation = value.find("orientation");
  if (!orientation) {
    value.fail(
        "a beam needs an orientation (the key 'orientation'), a direction across it towards which "
        "its n_y axis points");
  }
  const Eigen::Vector3d direction = read_direction(*orientation, scene);
  // Below 1e-6 the rounding of the positions would turn the section visibly.
  if ((q - p).normalized().cross(direction).norm() < 1e-6) {
    orientation->fail("the orientation is parallel to the beam; take a direction across it");
  }
  return direction;
}

void allow_beam_keys(const YamlReader& value, bool planar) {
  if (planar) {
    if (const auto given = value.find("orientation")) {
      given->fail("a beam of a planar scene has none");
    }
    value.allow_only({"type", "nodes", "EA", "EI", "shear", "mass_per_length", "mass",
                      "second_order", "stiffness", "damping", "damping_time", "rigid", "preload",
                      "divide"});
  } else {
    if (const auto given = value.find("EI")) given->fail("a spatial beam has two, EI_y and EI_z");
    value.allow_only({"type", "nodes", "orientation", "EA", "GJ", "EI_y", "EI_z", "shear_y",
                      "shear_z", "mass_per_length", "inertia_per_length", "mass", "second_order",
                      "stiffness", "damping", "damping_time", "rigid", "preload", "divide"});
  }
}

void read_beam_mass(const YamlReader& value, SceneBeam& beam) {
  if (const auto given = value.find("mass_per_length")) {
    beam.mass_per_length = given->non_negative();
  }
  if (const auto given = value.find("inertia_per_length")) {
    beam.inertia_per_length = given->non_negative();
  }
  if (const auto given = value.find("mass")) {
    beam.lumped_mass = given->one_of({"consistent", "lumped"}) == "lumped";
  }
}

}  // namespace

void read_beam(const YamlReader& value, const Scene& scene, const Eigen::Vector3d& p,
               const Eigen::Vector3d& q, SceneElement& element) {
  allow_beam_keys(value, scene.planar);
  if (!scene.planar) element.beam.orientation = read_orientation(value, scene, p, q);
  if (const auto given = value.find("rigid")) element.zero = read_rigid(*given, element);
  if (scene.planar) {
    for (const SectionKey& key : planar_keys) read_section_key(value, key, element);
  } else {
    for (const SectionKey& key : spatial_keys) read_section_key(value, key, element);
  }
  read_beam_mass(value, element.beam);
  if (const auto given = value.find("second_order")) element.beam.second_order = given->boolean();
  if (const auto given = value.find("damping_time")) {
    if (element.rigid()) given->fail("a rigid element has none");
    element.beam.damping_time = given->non_negative();
  }
  if (const auto given = value.find("stiffness")) {
    element.stiffness = read_symmetric(*given, element, "stiffness");
  }
  if (const auto given = value.find("damping")) {
    element.damping = read_symmetric(*given, element, "damping");
  }
  if (const auto given = value.find("preload")) element.preload = read_preload(*given, element);
}

}  // namespace stillframe

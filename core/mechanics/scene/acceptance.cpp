#include "core/mechanics/scene/acceptance.hpp"

#include <algorithm>

#include "core/mechanics/scene/references.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

namespace {

std::optional<double> read_ratio(const YamlReader& map, const std::string& key) {
  const auto value = map.find(key);
  return value ? std::optional(value->positive()) : std::nullopt;
}

std::optional<double> read_share(const YamlReader& map, const std::string& key) {
  const auto value = map.find(key);
  if (!value) return std::nullopt;
  const double share = value->non_negative();
  if (!(share <= 1)) value->fail("found " + value->text() + ", allowed is 0 to 1");
  return share;
}

void read_range(const YamlReader& map, const Scene& scene, AxisAcceptance& asked) {
  const bool ratio =
      asked.rms_of_floor || asked.rms_of_passive || asked.band_of_floor || asked.band_of_passive;
  for (const char* key : {"from_hz", "to_hz"}) {
    const auto value = map.find(key);
    if (value && !ratio) {
      value->fail(
          "a class is of 1 to 80 Hz; a range goes with rms_of_floor, rms_of_passive, "
          "band_of_floor or band_of_passive");
    }
  }
  if (const auto value = map.find("from_hz")) asked.from_hz = value->positive();
  const auto to = map.find("to_hz");
  if (scene.controller) asked.to_hz = std::min(asked.to_hz, scene.controller->sample_rate_hz / 2);
  if (to) {
    asked.to_hz = to->positive();
    if (scene.controller && asked.to_hz > scene.controller->sample_rate_hz / 2) {
      to->fail("found " + to->text() + ", allowed is up to half the sample rate, " +
               shown(scene.controller->sample_rate_hz / 2));
    }
  }
  if (!(asked.from_hz < asked.to_hz)) {
    map.fail("the range from " + shown(asked.from_hz) + " to " + shown(asked.to_hz) +
             " Hz is empty");
  }
}

AxisAcceptance read_axis(const std::string& axis, const YamlReader& map, const Scene& scene) {
  map.allow_only({"class", "rms_of_floor", "rms_of_passive", "band_of_floor", "band_of_passive",
                  "from_hz", "to_hz"});
  AxisAcceptance asked;
  asked.axis = axis;
  asked.rms_of_floor = read_ratio(map, "rms_of_floor");
  asked.rms_of_passive = read_ratio(map, "rms_of_passive");
  asked.band_of_floor = read_ratio(map, "band_of_floor");
  asked.band_of_passive = read_ratio(map, "band_of_passive");
  if (const auto value = map.find("class")) {
    asked.vibration_class = value->one_of({"VC-A", "VC-B", "VC-C", "VC-D", "VC-E", "VC-F", "VC-G"});
  }
  read_range(map, scene, asked);
  if (map.entries().empty()) {
    map.fail(
        "nothing is asked of the axis; name a class, rms_of_floor, rms_of_passive, "
        "band_of_floor or band_of_passive");
  }
  return asked;
}

void require_comparison(const std::string& name, const YamlReader& value, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneComparison& comparison : scene.comparisons) names.push_back(comparison.name);
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  const std::string near = nearest_name(name, names);
  value.fail("'compare' has no axis named '" + name + "'" +
             (near.empty() ? "" : "; the nearest name is '" + near + "'"));
}

}  // namespace

SceneAcceptance read_acceptance(const YamlReader& block, const Scene& scene) {
  block.allow_only({"axes", "limited_share", "lost_share", "discarded_share", "prediction_db"});
  SceneAcceptance accept;
  if (const auto axes = block.find("axes")) {
    for (const auto& [name, value] : axes->entries()) {
      require_comparison(name, value, scene);
      const auto maps = value.is_sequence() ? value.items() : std::vector<YamlReader>{value};
      if (maps.empty()) value.fail("nothing is asked of the axis");
      for (const YamlReader& map : maps) accept.axes.push_back(read_axis(name, map, scene));
    }
  }
  accept.limited_share = read_share(block, "limited_share");
  accept.lost_share = read_share(block, "lost_share");
  accept.discarded_share = read_share(block, "discarded_share");
  if (const auto value = block.find("prediction_db")) accept.prediction_db = value->positive();
  return accept;
}

SceneAcceptance acceptance_of(const Scene& scene) {
  const auto block = YamlReader::from_text(scene.text, scene.file).find("accept");
  return block ? read_acceptance(*block, scene) : SceneAcceptance();
}

}  // namespace stillframe

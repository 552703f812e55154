#include "tools/operating_point.hpp"

#include "core/errors/formatted.hpp"
#include "core/mechanics/model/local.hpp"
#include "core/mechanics/node_moves.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

const char* operating_point_in_words(const Scene& scene) {
  return scene.operating_point == OperatingPoint::equilibrium
             ? "its equilibrium"
             : "a snapshot of its motion as written";
}

Json to_json(const Model& model, const std::vector<NodeDisplacement>& displacements) {
  Json list = Json::array();
  for (const NodeDisplacement& item : displacements) {
    Json entry{{"node", item.node}};
    const Eigen::VectorXd displacement = item.displacement.head(model.planar ? 2 : 3);
    const Eigen::VectorXd rotation = item.rotation.tail(model.planar ? 1 : 3);
    entry["displacement"] = to_json(displacement);
    entry["rotation"] = item.has_rotation ? to_json(rotation) : Json();
    list.push_back(entry);
  }
  return list;
}

std::string table_of(const Model& model, const std::vector<NodeDisplacement>& displacements) {
  std::vector<std::string> header{"node", "dx m", "dy m"};
  if (!model.planar) header.insert(header.end(), {"dz m", "rx rad", "ry rad"});
  header.push_back("rz rad");
  report::Table table(header, 1);
  for (const NodeDisplacement& item : displacements) {
    std::vector<std::string> row{item.node};
    for (Index i = 0; i < (model.planar ? 2 : 3); ++i) {
      row.push_back(formatted("%.6g", item.displacement(i)));
    }
    for (Index i = model.planar ? 2 : 0; i < 3; ++i) {
      row.push_back(item.has_rotation ? formatted("%.6g", item.rotation(i)) : "-");
    }
    table.add(row);
  }
  return table.print();
}

}  // namespace stillframe::tools

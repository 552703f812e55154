#include "tools/spacar/dat_nodes.hpp"

#include <algorithm>

namespace stillframe::tools::spacar {

namespace {

bool is_in(const std::vector<int>& numbers, int number) {
  return std::find(numbers.begin(), numbers.end(), number) != numbers.end();
}

}  // namespace

void DatNodes::place(int position, const Eigen::Vector3d& at, int line) {
  places_[position] = {at, line};
}

void DatNodes::put(int position, int orientation) {
  std::vector<int>& positions = positions_of_[orientation];
  if (is_in(positions, position)) return;
  positions.push_back(position);
  orientations_of_[position].push_back(orientation);
}

bool DatNodes::pair(int position, int orientation) {
  if (!is_orientation(orientation)) put(position, orientation);
  return is_in(positions_of_.at(orientation), position);
}

bool DatNodes::carry(int position_p, int orientation, int position_q) {
  if (!is_orientation(orientation)) put(position_p, orientation);
  const std::vector<int>& positions = positions_of_.at(orientation);
  if (!is_in(positions, position_p) && !is_in(positions, position_q)) return false;
  put(position_p, orientation);
  put(position_q, orientation);
  return true;
}

std::optional<int> DatNodes::common(int orientation_p, int orientation_q) const {
  for (const int position : positions_of_.at(orientation_p)) {
    if (is_in(positions_of_.at(orientation_q), position)) return position;
  }
  return std::nullopt;
}

bool DatNodes::join(int orientation_p, int orientation_q) {
  const bool p = is_orientation(orientation_p), q = is_orientation(orientation_q);
  if (!p && !q) return false;
  if (!p) put(positions_of_.at(orientation_q).front(), orientation_p);
  if (!q) put(positions_of_.at(orientation_p).front(), orientation_q);
  const std::optional<int> position = common(orientation_p, orientation_q);
  if (position) joints_.push_back({.p = orientation_p, .q = orientation_q, .position = *position});
  return position.has_value();
}

std::string DatNodes::of_position(int position) { return "n" + std::to_string(position); }

std::string DatNodes::of_pair(int position, int orientation) const {
  std::string name = of_position(position);
  if (orientations_of_.at(position).front() == orientation) return name;
  name += 'r';
  return name += std::to_string(orientation);
}

std::string DatNodes::of_orientation(int orientation) const {
  return of_pair(positions_of_.at(orientation).front(), orientation);
}

std::pair<std::string, std::string> DatNodes::of_hinge(int orientation_p, int orientation_q) const {
  const int position = common(orientation_p, orientation_q).value();
  return {of_pair(position, orientation_p), of_pair(position, orientation_q)};
}

void DatNodes::add_pin(const std::string& p, const std::string& q, int line) {
  Element pin;
  pin.kind = Kind::hinge;
  pin.name = "pin" + std::to_string(++n_pins_);
  pin.p = p;
  pin.q = q;
  if (!model_.planar) pin.direction = Eigen::Vector3d::UnitX();
  pin.flexible = {1, 2, 3};
  pin.lines = {line};
  model_.elements.push_back(std::move(pin));
}

void DatNodes::make_nodes() {
  for (const auto& [position, place] : places_) make_nodes_at(position, place.first, place.second);
}

void DatNodes::make_nodes_at(int position, const Eigen::Vector3d& at, int line) {
  model_.nodes.push_back({.name = of_position(position), .position = at, .lines = {line}});
  const auto found = orientations_of_.find(position);
  if (found == orientations_of_.end()) return;
  const std::vector<int>& orientations = found->second;
  // Which of them hang together by hinges of the file: the rest is pinned to the first.
  std::map<int, int> group;
  for (const int orientation : orientations) group[orientation] = orientation;
  for (const Joint& joint : joints_) {
    if (joint.position != position) continue;
    const int from = group.at(joint.q), to = group.at(joint.p);
    for (auto& [orientation, its] : group) {
      if (its == from) its = to;
    }
  }
  std::set<int> held{group.at(orientations.front())};
  for (const int orientation : orientations) {
    if (orientation == orientations.front()) continue;
    const std::string name = of_pair(position, orientation);
    model_.nodes.push_back({.name = name, .position = at, .lines = {line}});
    if (held.insert(group.at(orientation)).second) add_pin(of_position(position), name, line);
  }
}

}  // namespace stillframe::tools::spacar

#include "tools/spacar/dat_nodes.hpp"

#include <algorithm>

namespace stillframe::tools::spacar {

void DatNodes::place(int position, const Eigen::Vector3d& at, int line) {
  places_[position] = {at, line};
}

bool DatNodes::pair(int position, int orientation) {
  const auto [found, is_new] = position_of_.try_emplace(orientation, position);
  if (is_new) orientations_of_[position].push_back(orientation);
  return found->second == position;
}

bool DatNodes::join(int orientation_p, int orientation_q) {
  const auto p = position_of_.find(orientation_p), q = position_of_.find(orientation_q);
  if (p == position_of_.end() && q == position_of_.end()) return false;
  if (p == position_of_.end()) {
    pair(q->second, orientation_p);
  } else if (q == position_of_.end()) {
    pair(p->second, orientation_q);
  } else if (p->second != q->second) {
    return false;
  }
  joined_.emplace_back(orientation_p, orientation_q);
  return true;
}

std::string DatNodes::of_position(int position) const { return "n" + std::to_string(position); }

std::string DatNodes::of_orientation(int orientation) const {
  const int position = position_of_.at(orientation);
  std::string name = of_position(position);
  if (orientations_of_.at(position).front() == orientation) return name;
  name += 'r';
  return name += std::to_string(orientation);
}

void DatNodes::add_ball_joint(const std::string& p, const std::string& q,
                              const std::set<int>& lines) {
  Element pin;
  pin.kind = Kind::hinge;
  pin.name = "pin" + std::to_string(++n_ball_joints_);
  pin.p = p;
  pin.q = q;
  if (!model_.planar) pin.direction = Eigen::Vector3d::UnitX();
  pin.flexible = {1, 2, 3};
  pin.lines = lines;
  model_.elements.push_back(std::move(pin));
}

std::string DatNodes::alone_at(int position, const std::string& name, const std::set<int>& lines) {
  const auto others = orientations_of_.find(position);
  if (others == orientations_of_.end()) return of_position(position);
  model_.nodes.push_back({.name = name, .position = places_.at(position).first, .lines = lines});
  add_ball_joint(of_position(position), name, lines);
  return name;
}

void DatNodes::make_nodes() {
  for (const auto& [position, place] : places_) {
    const auto& [at, line] = place;
    model_.nodes.push_back({.name = of_position(position), .position = at, .lines = {line}});
    const auto found = orientations_of_.find(position);
    if (found == orientations_of_.end()) continue;
    // Which of them hang together by hinges of the file: the rest is pinned to the first.
    std::map<int, int> group;
    for (const int orientation : found->second) group[orientation] = orientation;
    for (const auto& [p, q] : joined_) {
      if (!group.contains(p)) continue;
      const int from = group.at(q), to = group.at(p);
      for (auto& [orientation, its] : group) {
        if (its == from) its = to;
      }
    }
    std::set<int> held{group.at(found->second.front())};
    for (const int orientation : found->second) {
      if (orientation == found->second.front()) continue;
      const std::string name = of_orientation(orientation);
      model_.nodes.push_back({.name = name, .position = at, .lines = {line}});
      if (held.insert(group.at(orientation)).second) {
        add_ball_joint(of_position(position), name, {line});
      }
    }
  }
}

}  // namespace stillframe::tools::spacar

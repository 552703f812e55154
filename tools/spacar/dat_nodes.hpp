#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

/// SPACAR numbers positions and orientations apart, and an element names what it joins; a node of a
/// scene has both. So each pair that an element names becomes a node: the first of a position has
/// its name, and a further orientation at the same position becomes a node of its own, which a
/// hinge keeps there.
class DatNodes {
 public:
  explicit DatNodes(Model& model) : model_(model) {}

  /// Where a position is (X).
  void place(int position, const Eigen::Vector3d& at, int line);
  bool is_placed(int position) const { return places_.contains(position); }
  bool is_orientation(int number) const { return position_of_.contains(number); }

  /// An element stands on both. False if the orientation stands elsewhere already: a scene has one
  /// position for each.
  bool pair(int position, int orientation);
  /// A hinge of the file: orientations that are not anywhere yet are where its other one is. False
  /// if neither is, or both are and not at one position.
  bool join(int orientation_p, int orientation_q);

  /// The name of the node, once all pairs are known.
  std::string of_position(int position) const;
  std::string of_orientation(int orientation) const;
  /// A node at a position with an orientation that no other element has.
  std::string alone_at(int position, const std::string& name, const std::set<int>& lines);

  /// Writes the nodes into the model, and hinges without stiffness where orientations of one
  /// position hang together by nothing else.
  void make_nodes();

 private:
  Model& model_;
  std::map<int, std::pair<Eigen::Vector3d, int>> places_;
  std::map<int, std::vector<int>> orientations_of_;
  std::map<int, int> position_of_;
  std::vector<std::pair<int, int>> joined_;
  int n_ball_joints_ = 0;

  void add_ball_joint(const std::string& p, const std::string& q, const std::set<int>& lines);
};

}  // namespace stillframe::tools::spacar

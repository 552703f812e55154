#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

/// SPACAR numbers positions and orientations apart, and an element names what it joins; a node of a
/// scene has both. So each pair that an element names becomes a node: the first of a position has
/// its name, and a further orientation at the same position becomes a node of its own, which a
/// hinge keeps there. An orientation is at one position, its home, and wherever a rigid body
/// carries it.
class DatNodes {
 public:
  explicit DatNodes(Model& model) : model_(model) {}

  /// Where a position is (X).
  void place(int position, const Eigen::Vector3d& at, int line);
  bool is_placed(int position) const { return places_.contains(position); }
  bool is_orientation(int number) const { return positions_of_.contains(number); }

  /// A rigid body with this orientation from one position to another. False if neither has it and
  /// another one does.
  bool carry(int position_p, int orientation, int position_q);
  /// An element stands on both. False if the orientation is elsewhere.
  bool pair(int position, int orientation);
  /// A hinge of the file: an orientation that is nowhere yet is where its other one is. False if
  /// neither is anywhere, or if they have no position in common.
  bool join(int orientation_p, int orientation_q);

  /// Names of nodes, once all pairs are known: of a position, of an orientation at its home or at a
  /// position, and of both orientations of a hinge.
  static std::string of_position(int position);
  std::string of_orientation(int orientation) const;
  std::string of_pair(int position, int orientation) const;
  std::pair<std::string, std::string> of_hinge(int orientation_p, int orientation_q) const;

  /// Writes the nodes into the model, and hinges without stiffness where orientations of one
  /// position hang together by nothing else.
  void make_nodes();

 private:
  struct Joint {
    int p, q, position;
  };
  Model& model_;
  std::map<int, std::pair<Eigen::Vector3d, int>> places_;
  std::map<int, std::vector<int>> orientations_of_, positions_of_;
  std::vector<Joint> joints_;
  int n_pins_ = 0;

  void put(int position, int orientation);
  std::optional<int> common(int orientation_p, int orientation_q) const;
  void make_nodes_at(int position, const Eigen::Vector3d& at, int line);
  void add_pin(const std::string& p, const std::string& q, int line);
};

}  // namespace stillframe::tools::spacar

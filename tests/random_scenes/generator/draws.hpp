#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

namespace stillframe::random_scenes {

/// Numbers of a generator whose output the standard fixes; it fixes none of the distributions.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}

  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Evenly on a logarithmic axis.
  double scale(double low, double high) { return low * std::pow(high / low, unit()); }
  bool chance(double probability) { return unit() < probability; }
  /// 0 to end - 1.
  int below(int end) { return static_cast<int>(unit() * end); }
  int whole(int low, int high) { return low + below(high - low + 1); }
  template <class Item>
  const Item& one_of(const std::vector<Item>& items) {
    return items[static_cast<size_t>(below(static_cast<int>(items.size())))];
  }
  /// Evenly in the cube from -1 to 1; planar: z = 0.
  Eigen::Vector3d point(bool planar) {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return {x, y, planar ? 0 : z};
  }
  Eigen::Vector3d direction(bool planar) {
    for (;;) {
      const Eigen::Vector3d p = point(planar);
      if (p.norm() > 0.1 && p.norm() <= 1) return p.normalized();
    }
  }
  /// Planar: about z.
  Eigen::Matrix3d rotation(bool planar) {
    const Eigen::Vector3d axis = planar ? Eigen::Vector3d::UnitZ() : direction(false);
    return Eigen::AngleAxisd(between(-3, 3), axis).toRotationMatrix();
  }

 private:
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  std::mt19937_64 engine_;
};

}  // namespace stillframe::random_scenes
